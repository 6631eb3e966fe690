"""The lists of `frictionbench list`: a paragraph for each scene, solver or suite, wrapped to the terminal."""

import json
from collections.abc import Callable, Iterable, Iterator
from dataclasses import fields
from typing import Any

from frictionbench.commands.table import paragraph, screen
from frictionbench.harness.plans.suites import SUITES
from frictionbench.problems.instances import instances
from frictionbench.problems.scenes import scenes
from frictionbench.solvers import SolverInfo, available, find
from frictionbench.solvers.plugins import distribution, installed

Item = tuple[str, list[str]]  # a heading and its paragraphs
SPACES = {2: "planar", 3: "spatial"}


def show(what: str) -> None:
    """Print the scenes, solvers or suites."""
    makers: dict[str, Callable[[], Iterator[Item]]] = {
        "scenes": _scenes,
        "solvers": _solvers,
        "suites": _suites,
    }
    width = screen()
    for heading, texts in makers[what]():
        print(heading)
        for text in filter(None, texts):
            print("\n".join(paragraph(text, width)))


def show_json(what: str) -> None:
    """Print the scenes, solvers or suites as a JSON object by name."""
    listed: dict[str, dict[str, Any]] = {}
    if what == "scenes":
        made: Any
        for name, made in {**scenes(), **instances()}.items():
            facts = {"summary": made.summary, "dimension": made.dimension, "one_step": name in instances()}
            listed[name] = facts | {"parameters": made.parameters}
    elif what == "solvers":
        for name, info in sorted(available().items()):
            facts = {"summary": info.summary, "family": info.family, "model": info.model, "dimension": info.dimension}
            listed[name] = facts | {"variants": info.specs, "missing": info.missing}
    else:
        for name, make in SUITES.items():
            plan = make()
            facts = {"summary": (make.__doc__ or "").strip(), "solvers": plan.variants, "tolerances": plan.tolerances}
            listed[name] = facts | {"takes": plan.expects}
    print(json.dumps(listed, indent=1))


def _scenes() -> Iterator[Item]:
    listed: dict[str, Any] = {**scenes(), **instances()}
    by_maker: dict[str, list[str]] = {}
    for name, generator in listed.items():
        by_maker.setdefault(generator.make.__name__, []).append(name)
    for maker in filter(by_maker.get, listed):
        own, names = listed[maker], by_maker[maker]
        others = [f"{name}, which is {maker}[{_changed(listed[name], own)}]" for name in names if name != maker]
        also = f"also under the name {'; '.join(others)}" if others else ""
        settings = _listed(own.parameters.items())
        kind = SPACES[own.dimension] + ("; a problem of one step" if maker in instances() else "")
        yield f"{maker}  ({kind})", [own.summary, f"settings: {settings}" if settings else "", also]


def _changed(generator: Any, own: Any) -> str:
    """The parameters by which a generator differs from that of its maker's own name."""
    return _listed([pair for pair in generator.parameters.items() if pair[1] != own.parameters[pair[0]]], ",")


def _listed(parameters: Iterable[tuple[str, Any]], comma: str = ", ") -> str:
    return comma.join(f"{name}={_short(value)}" for name, value in parameters)


def _solvers() -> Iterator[Item]:
    for name, info in sorted(available().items()):
        facts = [info.family, info.model, " and ".join(SPACES[d] for d in info.dimension)]
        facts += ["takes a start"] * info.warm_start + ["portfolio"] * bool(info.members)
        variants = f"variants: {', '.join(_with_reason(spec) for spec in info.specs)}" if info.variants else ""
        yield f"{name}  ({'; '.join([*facts, *_libraries(info)])})", [info.summary, _settings(info), variants]
    for name, point in installed().items():  # without importing their code
        yield f"{name}  ({distribution(point)})", [f"installed plug-in: {point.value}"]


def _libraries(info: SolverInfo) -> list[str]:
    """The versions of the libraries of its available variants; if none is available, what is missing."""
    found = [find(spec)[0] for spec in info.specs]
    installed_versions = [library for fact in found if not fact.missing for library in fact.version.split(", ") if library]
    if installed_versions or not any(fact.missing for fact in found):
        return list(dict.fromkeys(installed_versions))
    return [f"not available: {found[0].missing}"]


def _with_reason(spec: str) -> str:
    missing = find(spec)[0].missing
    return f"{spec} ({missing})" if missing else spec


def _settings(info: SolverInfo) -> str:
    made: Any = info.make()
    settings = _listed((each.name, getattr(made, each.name)) for each in fields(made))
    return f"settings: {settings}" if settings else ""


def _suites() -> Iterator[Item]:
    for name, make in SUITES.items():
        plan = make()
        tolerances = ", ".join(f"{tol:g}" for tol in plan.tolerances)
        parts = {
            "sources of problems": plan.sources,
            "simulations": plan.simulations,
            "maps": plan.maps,
            "batches": plan.batches,
            "solvers": plan.variants,
        }
        numbers = ", ".join(f"{what}: {len(part)}" for what, part in parts.items() if part)
        takes = f"takes {plan.expects} with one worker on two cores" if plan.expects else ""
        yield name, [(make.__doc__ or "").strip(), f"{numbers}; tolerances: {tolerances}", takes]


def _short(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
