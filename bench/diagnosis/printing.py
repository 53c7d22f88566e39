"""What a terminal shows when a diagnosis is done: the answer, its numbers, where the files are, what to do next."""

from rich.console import Console
from rich.table import Table
from rich.text import Text

from bench.diagnosis.diagnosing import ANSWER_FILE, PAGE_FILE, Written
from bench.diagnosis_report.words import BADGES, gain_words, headline, parameter_texts, percent, plain
from bench.report.formatting import number
from bench.report.summary import VERDICT_STYLES
from model_diagnosis.result import Diagnosis

MOST_FAULTS = 12


def print_diagnosis(written: Written, console: Console) -> None:
    """Print a diagnosis for people."""
    diagnosis = written.diagnosis
    badge, words = BADGES[diagnosis.verdict]
    console.print()
    console.print(Text(f" {words.upper()} ", f"bold reverse {VERDICT_STYLES[badge]}"))
    console.print(headline(diagnosis), style="bold")
    _print_causes(diagnosis, console)
    _print_terms(diagnosis, console)
    _print_faults(diagnosis, console)
    if diagnosis.gain is not None:
        overall = diagnosis.gain.overall
        where = "in cross-validation" if diagnosis.gain.cross_validated else "on held-out manoeuvres"
        console.print(f"\nerror left {where}: {gain_words(overall.ratio, overall.low, overall.high)}")
    if diagnosis.next_manoeuvre is not None:
        following = diagnosis.next_manoeuvre
        console.print(f"\ndrive next: [bold]{plain(following.name)}[/]  {following.description}")
    if diagnosis.insufficient:
        names = ", ".join(plain(name) for name in diagnosis.insufficient)
        console.print(f"\nnot excited by this data, so nothing can be said of: {names}", style="dim")
    for remark in diagnosis.remarks:
        console.print(f"remark: {remark}", style="dim", markup=False)
    console.print(f"\npage:  {written.folder / PAGE_FILE}", markup=False)
    files = [ANSWER_FILE, *([diagnosis.extension_file] if diagnosis.extension_file else [])]
    console.print(f"files: {written.folder}/ {' '.join(files)}", markup=False)
    if diagnosis.extension_file:
        console.print(f"next:  bench run stops/dry --vehicle {written.folder / diagnosis.extension_file}", markup=False)


def _print_causes(diagnosis: Diagnosis, console: Console) -> None:
    if not diagnosis.causes:
        return
    table = Table(box=None, padding=(0, 2, 0, 0), header_style="dim")
    heads = ["cause", "probability", "parameter", "value", "90 % interval", "vehicle file", "change"]
    groups = [", ".join(plain(name) for name in cause.group if name != cause.effect) for cause in diagnosis.causes]
    if any(groups):
        heads.append("cannot be told from")
    for head in heads:
        table.add_column(head, justify="right" if head in ("probability", "value", "vehicle file") else "left")
    for cause, others in zip(diagnosis.causes, groups, strict=True):
        for row, text in enumerate(parameter_texts(cause)):
            cells = (text.name, text.value, text.interval, text.nominal, text.change)
            names = (plain(cause.effect), percent(cause.probability)) if row == 0 else ("", "")
            table.add_row(*names, *cells, *([others] if any(groups) and row == 0 else []))
    console.print()
    console.print(table)


def _print_terms(diagnosis: Diagnosis, console: Console) -> None:
    for term in diagnosis.discovered_terms:
        numbers = ", ".join(
            f"{number(value, 4)} [{number(low, 3)}, {number(high, 3)}] {unit}"
            for value, low, high, unit in zip(term.coefficients, term.low, term.high, term.units, strict=True)
        )
        console.print(f"\nunknown term added to {plain(term.target)}: {term.formula}   {numbers}", markup=False)


def _print_faults(diagnosis: Diagnosis, console: Console) -> None:
    if diagnosis.data_faults:
        console.print("\nfaults of the data", style="dim")
    for fault in diagnosis.data_faults[:MOST_FAULTS]:
        done = "repaired" if fault.repaired else "reported"
        message = fault.message if fault.channel in fault.message else f"{fault.channel}: {fault.message}"
        console.print(f"  {plain(fault.kind)}, {done}: {message}", markup=False)
    if len(diagnosis.data_faults) > MOST_FAULTS:
        console.print(f"  … {len(diagnosis.data_faults) - MOST_FAULTS} more on the page")
