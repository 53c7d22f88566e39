"""One run of the challenge, from the generator to the figures."""

import json
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from bench.challenge.answering import answer_all
from bench.challenge.figures import Figures, figures_of
from bench.challenge.generator import FAMILIES, GENERATORS, generate, separate
from bench.challenge.looks import record_look, refuse_second_look
from bench.challenge.measuring import Measurement, measure_all
from bench.challenge.planned import LOOK_ALIKES
from bench.challenge.scoring import CaseScore, score_case
from bench.challenge.seals import open_seal, record_answers, recorded_answers
from bench.challenge.true_gain import GAINING_FAMILIES
from bench.verdict.output_files import replace_file
from signals.errors import InputError, unknown_name

Progress = Callable[[str, float], None]

_SINGLE = "single"
"""Family whose values are judged."""

_GENERATED, _ANSWERED, _MEASURED = 0.1, 0.7, 0.98
SCORE_FILE = "score.json"


@dataclass(frozen=True)
class ChallengeResult:
    """Scores and figures of a run, and the digest of the code that answered, of several ones joined by +."""

    seed: int
    count: int
    family: str | None
    generator: str
    scores: list[CaseScore]
    figures: Figures
    folder: Path | None
    code: str

    def as_json(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "seed": self.seed,
            "n": self.count,
            "family": self.family,
            "generator": self.generator,
            "code": self.code,
            "figures": [figure.as_json() for figure in self.figures.shares],
            "sizes": {name: asdict(sizes) for name, sizes in self.figures.sizes.items()},
            "confusion": self.figures.confusion,
            "reliability": [asdict(part) for part in self.figures.bins],
            "cases": [asdict(score) for score in self.scores],
            "missed": [figure.name for figure in self.figures.missed],
        }


def run_challenge(
    *,
    seed: int,
    count: int,
    family: str | None = None,
    generator: str = "first",
    jobs: int = 1,
    out: Path | None = None,
    looks: Path | None = None,
    measure_gain: bool = True,
    check_plans: bool = True,
    progress: Progress | None = None,
) -> ChallengeResult:
    """Generate cases, diagnose them all, record the answers, open the seals, score.

    Parameters
    ----------
    seed : below 10 000 for tuning, 10 000 to 10 019 in CI, from 1 000 000 on for the published table (each once)
    count : number of cases
    family : one family only; None for the mixture
    generator : ``first``, or ``second`` with another tyre curve
    jobs : worker processes
    out : folder to keep cases, answers and score in; a folder that a broken-off run left goes on from its answers
    looks : log of looks at table seeds
    measure_gain : compare held-out gains with those of the true effect, which costs another fit per case
    check_plans : record look-alikes again with the manoeuvre or sensor that was proposed, and diagnose that
    progress : called with what is being done and the share done, 0 to 1

    Raises
    ------
    InputError
        For an unknown family or generator, or a table seed that was scored before.
    """
    if family is not None and family not in FAMILIES:
        raise unknown_name("family", family, FAMILIES)
    if generator not in GENERATORS:
        raise unknown_name("generator", generator, GENERATORS)
    if count < 1:
        raise InputError("no cases", found=str(count), allowed="at least 1")
    refuse_second_look(seed, family, generator, recorded_answers(out) if out is not None else None, looks)
    if out is None:
        with TemporaryDirectory(prefix="challenge-") as folder:
            run = _Run(Path(folder), seed, count, family, generator, jobs, looks, measure_gain, check_plans, progress)
            return run.result(None)
    return _Run(out, seed, count, family, generator, jobs, looks, measure_gain, check_plans, progress).result(out)


@dataclass
class _Run:
    folder: Path
    seed: int
    count: int
    family: str | None
    generator: str
    jobs: int
    looks: Path | None
    measure_gain: bool
    check_plans: bool
    progress: Progress | None

    def result(self, kept: Path | None) -> ChallengeResult:
        cases = self._cases()
        answers = answer_all(cases, self.folder / "answers", self.jobs, self._answered)
        recorded = record_answers(self.folder, answers)
        record_look(self.seed, self.count, self.family, self.generator, recorded, self.looks)
        labels = [self._label(answers, case) for case in cases]
        contents = [json.loads(answer.read_text(encoding="utf-8")) for answer in answers]
        code = "+".join(sorted({content.get("code", "unknown") for content in contents}))
        measured = self._measured(cases, labels, contents)
        scores = []
        for index, (case, label, content) in enumerate(zip(cases, labels, contents, strict=True)):
            self._tell(f"score of {case.name}", _MEASURED + (1.0 - _MEASURED) * index / self.count)
            scores.append(self._score(index, case, label, content, measured.get(case.name, {})))
        result = ChallengeResult(
            self.seed, self.count, self.family, self.generator, scores, figures_of(scores), kept, code
        )
        replace_file(self.folder / SCORE_FILE, json.dumps(result.as_json(), indent=1).encode())
        return result

    def _tell(self, text: str, share: float) -> None:
        if self.progress is not None:
            self.progress(text, share)

    def _answered(self, name: str, done: int, count: int) -> None:
        self._tell(f"diagnosis of {name}", _GENERATED + (_ANSWERED - _GENERATED) * done / count)

    def _measured(
        self, cases: list[Path], labels: list[dict[str, Any]], contents: list[dict[str, Any]]
    ) -> dict[str, dict[str, Any]]:
        """What needs more fits, of the cases that were answered."""
        measurements = [
            Measurement(
                case,
                self.folder,
                label,
                content["diagnosis"],
                {"seed": self.seed, "index": index, "family": self.family, "generator": self.generator},
                wanted,
            )
            for index, (case, label, content) in enumerate(zip(cases, labels, contents, strict=True))
            if "diagnosis" in content and (wanted := self._wanted(label["family"]))
        ]
        return measure_all(measurements, self.jobs, self._measured_one)

    def _wanted(self, family: str) -> frozenset[str]:
        """What is measured at a case of a family."""
        families = {
            "separated": (LOOK_ALIKES,) if self.check_plans else (),
            "gain_share": GAINING_FAMILIES if self.measure_gain else (),
            "value_std": (_SINGLE,),
        }
        return frozenset(name for name, of in families.items() if family in of)

    def _measured_one(self, name: str, done: int, count: int) -> None:
        self._tell(f"measurement at {name}", _ANSWERED + (_MEASURED - _ANSWERED) * done / count)

    def _cases(self) -> list[Path]:
        cases, sealed = self.folder / "cases", self.folder / "sealed"
        wanted = {"seed": self.seed, "n": self.count, "family": self.family, "generator": self.generator}
        manifest = cases / "manifest.json"
        if manifest.is_file():
            made = json.loads(manifest.read_text(encoding="utf-8"))
            if any(made[key] != value for key, value in wanted.items()):
                raise InputError(f"{self.folder}: holds another challenge", mend="give an empty folder: --out DIR")
            found = [cases / f"case_{index:04d}" for index in range(self.count)]
            if all((case / "vehicle.yaml").is_file() for case in found):
                return found
        self._tell("cases", 0.0)
        return generate(cases, sealed, seed=self.seed, count=self.count, family=self.family, generator=self.generator)

    def _label(self, answers: list[Path], case: Path) -> dict[str, Any]:
        return open_seal(self.folder, answers, case, self.folder / "sealed" / f"{case.name}.json")

    def _score(
        self, index: int, case: Path, label: dict[str, Any], answer: dict[str, Any], measured: dict[str, Any]
    ) -> CaseScore:
        def asked(number: int, rivals: Any) -> list[dict[str, float | None]]:
            return separate(rivals, seed=self.seed, index=number, family=self.family, generator=self.generator)

        score = score_case(case.name, index, label, answer, asked)
        return replace(score, **measured)
