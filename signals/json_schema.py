"""JSON Schemas of file models for editors: draft-07, quantities as number or text with a unit."""

from typing import Any

from pydantic import BaseModel

DRAFT = "http://json-schema.org/draft-07/schema#"
QUANTITY_PATTERN = r"^\s*[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?\s*\S.*$"


def draft7_schema(model: type[BaseModel], title: str, *, partial: bool = False) -> dict[str, Any]:
    """Schema of a file model.

    Parameters
    ----------
    partial : bool
        No field is required: for files that others complete (``include``, ``extends``).
    """
    schema = model.model_json_schema(mode="validation", by_alias=True, ref_template="#/definitions/{model}")
    if "$defs" in schema:
        schema["definitions"] = schema.pop("$defs")
    result: dict[str, Any] = _converted(schema, partial)
    return {"$schema": DRAFT, "title": title, **{key: value for key, value in result.items() if key != "title"}}


def _converted(node: Any, partial: bool) -> Any:
    if isinstance(node, list):
        return [_converted(item, partial) for item in node]
    if not isinstance(node, dict):
        return node
    # a mapping of names (the properties of an object) may have any key; only schemas have keywords
    result = {
        key: {name: _converted(inner, partial) for name, inner in value.items()}
        if key in ("properties", "definitions") and isinstance(value, dict)
        else _converted(value, partial)
        for key, value in node.items()
        if key not in ("discriminator", "source", "neutral")
    }
    if partial:
        result.pop("required", None)
    unit = result.pop("unit", None)
    if isinstance(unit, str):
        result = _quantity(result, unit)
    if "$ref" in result and len(result) > 1:
        # draft-07 ignores what stands beside a reference
        reference = result.pop("$ref")
        result["allOf"] = [{"$ref": reference}]
    return result


def _quantity(node: dict[str, Any], unit: str) -> dict[str, Any]:
    """A number in SI units, or a text with a unit; the unit is shown with the description."""
    shown = f"[{unit}]" if unit != "1" else ""
    node["description"] = " ".join(part for part in (node.get("description", ""), shown) if part)
    if not node["description"]:
        del node["description"]
    return _numbers_or_texts(node)


def _numbers_or_texts(node: dict[str, Any]) -> dict[str, Any]:
    if node.get("type") in ("number", "integer"):
        limits = ("type", "minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum")
        number = {key: node.pop(key) for key in limits if key in node}
        node["anyOf"] = [number, {"type": "string", "pattern": QUANTITY_PATTERN}]
        return node
    for key in ("anyOf", "items"):
        inner = node.get(key)
        if isinstance(inner, dict):
            node[key] = _numbers_or_texts(inner)
        elif isinstance(inner, list):
            node[key] = [part for entry in inner for part in _flat(_numbers_or_texts(entry))]
    return node


def _flat(node: dict[str, Any]) -> list[dict[str, Any]]:
    return node["anyOf"] if set(node) == {"anyOf"} else [node]
