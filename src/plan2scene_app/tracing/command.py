"""``plan2scene trace``: a picture of a plan becomes a plan."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def trace_plan(
    picture: Annotated[Path, typer.Argument(help="Picture of a plan, of one storey.")],
    out: Annotated[Path, typer.Option(help="The plan JSON to write.")],
    metres_per_pixel: Annotated[
        float | None, typer.Option(min=1e-6, help="Scale of the picture, where known.")
    ] = None,
    model: Annotated[Path | None, typer.Option(help="Other weights of the plan network.")] = None,
) -> None:
    """Read a plan from its picture; say what is doubtful, to be mended in the editor."""
    from plan2scene.io import keep_inputs
    from plan2scene_app.tracing.trace import traced_files, write_trace

    for path in traced_files(out):
        keep_inputs(path, [picture, *([model] if model else [])])
    plan, lines = write_trace(picture, out, metres_per_pixel=metres_per_pixel, model=model)
    for line in lines:
        typer.echo(f"doubt: {line}")
    typer.echo(
        f"{len(plan.rooms)} rooms, {len(plan.openings)} openings; "
        f"{100 * plan.file_metres:.3g} cm a pixel "
        f"({plan.scale.source}, {plan.scale.confidence:.0%} sure); {len(lines)} doubts"
    )
    for path in traced_files(out):
        typer.echo(path)
    if lines:
        typer.echo(f"to mend it: plan2scene edit {picture} --out editor.html")
