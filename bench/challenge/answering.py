"""Diagnoses of all cases, in worker processes that see nothing but a case's folder."""

import json
import os
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from bench.challenge.code_digest import code_digest
from bench.execution.worker import initialise
from bench.verdict.output_files import replace_file

_THREAD_SETTINGS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")

_TASKS_PER_WORKER = 25
"""Tasks after which workers are started anew, since what they keep grows. The executor's own ``max_tasks_per_child``
can wait for ever for a worker that has ended (CPython issue 115634)."""


def answer_case(case: Path) -> dict[str, Any]:
    """Diagnosis of one case as plain data; a refusal by the tool is an answer too."""
    from model_diagnosis.diagnosis import diagnose
    from signals.errors import BenchError

    code, began = code_digest(), time.perf_counter()
    try:
        findings = diagnose(
            logs_in(case / "logs"),
            case / "vehicle.yaml",
            case / "channels.yaml",
            hold_out=logs_in(case / "held_out"),
        )
    except BenchError as error:
        return {"error": str(error), "seconds": time.perf_counter() - began, "code": code}
    found = findings.diagnosis.model_dump(mode="json")
    seconds = time.perf_counter() - began
    return {"diagnosis": found, "linear": dict(findings.evidence), "seconds": seconds, "code": code}


def logs_in(folder: Path) -> list[Path]:
    """Log files of a folder, by name."""
    return sorted(path for path in folder.iterdir() if path.is_file())


def in_workers(function: Callable[..., None], tasks: Sequence[tuple[Any, ...]], jobs: int) -> Iterator[int]:
    """Call a function with the arguments of each task, in worker processes; numbers of tasks as they are done."""
    if not tasks:
        return
    for name in _THREAD_SETTINGS:  # before the workers start: they read them at import
        os.environ.setdefault(name, "1")
    for begin in range(0, len(tasks), jobs * _TASKS_PER_WORKER):
        numbers = range(begin, min(begin + jobs * _TASKS_PER_WORKER, len(tasks)))
        workers = min(jobs, len(numbers))
        with ProcessPoolExecutor(workers, get_context("spawn"), initializer=initialise, initargs=("",)) as pool:
            futures = {pool.submit(function, *tasks[number]): number for number in numbers}
            try:
                for future in as_completed(futures):
                    future.result()
                    yield futures[future]
            except BaseException:
                pool.shutdown(cancel_futures=True)  # an error is told now, not when all other tasks are done
                raise


def answer_all(
    cases: Sequence[Path], folder: Path, jobs: int, told: Callable[[str, int, int], None] | None = None
) -> list[Path]:
    """Diagnose every case and write ``<case>.json`` into ``folder``; answers that are there already are kept."""
    folder.mkdir(parents=True, exist_ok=True)
    answers = [folder / f"{case.name}.json" for case in cases]
    missing = [(case, answer) for case, answer in zip(cases, answers, strict=True) if not answer.is_file()]
    done = len(cases) - len(missing)
    for number in in_workers(_answer_to_file, [(str(case), str(answer)) for case, answer in missing], jobs):
        done += 1
        if told is not None:
            told(missing[number][0].name, done, len(cases))
    return answers


def _answer_to_file(case: str, answer: str) -> None:
    try:
        content = answer_case(Path(case))
    except Exception as error:  # a defect of the tool is a wrong answer, and must not end the challenge
        content = {"error": f"{type(error).__name__}: {error}", "defect": True, "code": code_digest()}
    replace_file(Path(answer), json.dumps(content, indent=1).encode())
