"""A challenge's score on the console, and its reliability diagram as a picture."""

from html import escape
from pathlib import Path

from bench.challenge.figures import Figure
from bench.challenge.intervals import Bin
from bench.challenge.running import ChallengeResult

_MARKS = {True: "met", False: "MISSED", None: ""}
_SIZE, _MARGIN = 320, 40


def text_of(result: ChallengeResult) -> str:
    """Figures, confusion matrix and reliability as text."""
    about = f"seed {result.seed}, {result.count} cases, {result.generator} generator"
    lines = [f"blind challenge: {about}" + (f", family {result.family}" if result.family else ""), ""]
    lines += [_line(figure) for figure in result.figures.shares if figure.count]
    lines += ["", "hidden → answered"]
    width = max((len(hidden) for hidden in result.figures.confusion), default=0)
    for hidden, answers in result.figures.confusion.items():
        lines.append(f"  {hidden:<{width}}  " + ", ".join(f"{name} {count}" for name, count in answers.items()))
    if result.figures.bins:
        lines += ["", "stated probability  right  statements"]
        lines += [f"  {part.stated:16.2f}  {part.right:5.2f}  {part.count}" for part in result.figures.bins]
    missed = ", ".join(figure.name for figure in result.figures.missed)
    lines += ["", f"missed: {missed}" if missed else "every required figure that has cases is met"]
    return "\n".join(lines)


def _line(figure: Figure) -> str:
    if figure.value is None:
        return f"  {figure.name:<42} –"
    is_share = _is_share(figure)
    value = f"{100 * figure.value:5.1f} %" if is_share else f"{figure.value:7.3g}"
    interval = f"[{100 * (figure.low or 0.0):.1f}, {100 * (figure.high or 0.0):.1f}]" if is_share else ""
    mark = _MARKS[figure.met]
    required = f"required {_range(figure, is_share)}" if figure.required else ""
    return f"  {figure.name:<42} {value:>8} {interval:<15} of {figure.count:<5} {required:<24} {mark}".rstrip()


def table_row(figure: Figure) -> str:
    """A figure as a row of a Markdown table: name, required, found, interval, cases, whether it is met."""
    is_share = _is_share(figure)
    value = "–" if figure.value is None else f"{100 * figure.value:.1f} %" if is_share else f"{figure.value:.3g}"
    interval = f"{100 * (figure.low or 0.0):.1f} … {100 * (figure.high or 0.0):.1f} %" if is_share else ""
    required = _range(figure, is_share) if figure.required else ""
    mark = _MARKS[figure.met]
    return f"| {figure.name} | {required} | {value} | {interval} | {figure.count} | {mark} |"


def _is_share(figure: Figure) -> bool:
    return figure.low is not None and figure.high is not None


def _range(figure: Figure, is_share: bool) -> str:
    low, high = figure.required or (0.0, 1.0)
    scale, unit = (100.0, " %") if is_share else (1.0, "")
    if low <= 0.0:
        return f"≤ {scale * high:g}{unit}"
    return f"≥ {scale * low:g}{unit}" if high >= 1.0 else f"{scale * low:g}…{scale * high:g}{unit}"


def reliability_picture(bins: list[Bin], title: str, path: Path) -> None:
    """Reliability diagram as SVG: stated probability across, share that was right upwards; area by statements."""
    span = _SIZE - 2 * _MARGIN

    def place(across: float, up: float) -> tuple[float, float]:
        return _MARGIN + across * span, _SIZE - _MARGIN - up * span

    (x0, y0), (x1, y1) = place(0.0, 0.0), place(1.0, 1.0)
    marks = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_SIZE} {_SIZE}" font-family="sans-serif" '
        'font-size="11">',
        f'<rect width="{_SIZE}" height="{_SIZE}" fill="white"/>',
        f'<path d="M{x0} {y1}V{y0}H{x1}" fill="none" stroke="black"/>',
        f'<line x1="{x0}" y1="{y0}" x2="{x1}" y2="{y1}" stroke="gray" stroke-dasharray="4"/>',
        f'<text x="{_SIZE / 2}" y="20" text-anchor="middle">{escape(title)}</text>',
        f'<text x="{_SIZE / 2}" y="{_SIZE - 8}" text-anchor="middle">stated probability</text>',
        f'<text x="14" y="{_SIZE / 2}" text-anchor="middle" transform="rotate(-90 14 {_SIZE / 2})">share right</text>',
    ]
    for share in (0.0, 0.5, 1.0):
        (x, _), (_, y) = place(share, 0.0), place(0.0, share)
        marks.append(f'<text x="{x}" y="{y0 + 14}" text-anchor="middle">{share:g}</text>')
        marks.append(f'<text x="{x0 - 6}" y="{y + 4}" text-anchor="end">{share:g}</text>')
    for part in bins:
        x, y = place(part.stated, part.right)
        radius = min(3.0 + part.count**0.5, 14.0)
        marks.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius:.1f}" fill="steelblue" fill-opacity="0.7"/>')
        marks.append(f'<text x="{x:.1f}" y="{y - radius - 3:.1f}" text-anchor="middle">{part.count}</text>')
    path.write_text("\n".join([*marks, "</svg>"]), encoding="utf-8")
