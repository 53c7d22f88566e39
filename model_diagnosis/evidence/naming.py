"""The causes that a selection comes to: each the most probable of those that could stand in its place."""

from collections.abc import Callable, Sequence

from model_diagnosis.evidence.answer import CauseDetail, Physical, causes
from model_diagnosis.evidence.lookalikes import look_alikes
from model_diagnosis.evidence.search import Search
from model_diagnosis.evidence.selection import Accepted, Selection, Selector


def named(
    search: Search,
    selector: Selector,
    selection: Selection,
    forced: Callable[[Accepted], Sequence[int]],
    physical: Physical,
    led: frozenset[int] = frozenset(),
) -> tuple[Selection, list[CauseDetail]]:
    """Causes of a selection, and the selection that they are.

    Effects that are improbable in their own place are left out. One of whose group another is clearly more probable
    gives its place to that: the most acceptable of a group is not always the most probable.

    Parameters
    ----------
    forced : effects that are grouped with an accepted one whatever the data says
    led : effects that have given or taken a place before
    """
    alike = [look_alikes(search, selection, one, forced(one)) for one in selection.accepted]
    found = causes(search, selection, alike, physical)
    if improbable := [one.accepted for one in found if one.is_improbable]:
        return named(search, selector, selector.without(selection, improbable), forced, physical, led)
    for one in found:
        own, better = one.accepted.hypothesis, one.alike.leader
        if better is not None and own.effect not in led:
            other = selector.led_by(selection, one.accepted, better.hypothesis, better.theta)
            taken = led | {own.effect, better.hypothesis.effect}
            return named(search, selector, other, forced, physical, taken)
    return selection, found
