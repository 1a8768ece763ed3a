"""The critic against robustness, with the cumulative success (App. A.6), and its maps (Fig. 5)."""

import numpy as np

from core.truth import spearman
from studio.bench.figures import maps, scatters
from studio.bench.report.page import Page
from studio.bench.report.rows import Row, Rows, by, job_of, main, name

BEST = 0.1
"""Share of the samples that the critic values most."""


def critics(page: Page, rows: Rows) -> None:
    """A section for each robot and kind of training of which samples were kept."""
    sampled = [row for row in main(rows) if row["critic_scores"]]
    for (robot, label), part in by(sampled, lambda row: (row["robot"], name(row))).items():
        count = max(job_of(row)["critic_samples"] for row in part)
        page.heading(f"Critic against robustness: {label} on {robot}")
        page.text(
            f"Up to {count} random schedules a run, each from a random initial state and carried "
            "out once. The line is the share of satisfying traces among schedules that the critic "
            "values at least as much. The picture shows the first seed, the table every run."
        )
        first = [row for row in part if row["seed"] == min(one["seed"] for one in part)]
        key = f"critic-{robot}-{label.replace(', ', '-').replace(' ', '-')}"
        page.figure(key, "Critic against robustness", lambda path, p=first: scatters(path, p))
        head = ("task", "seed", "samples", "rank correlation", "success", "success, best tenth")
        page.table(key, head, [_line(row) for row in part])
        mapped = [row for row in first if row["critic_map"]]
        if mapped:
            page.figure(
                f"{key}-maps",
                "The critic over the first two times, from the middle of the initial set; blank "
                "where legs are too short",
                lambda path, p=mapped: maps(path, p),
            )


def _line(row: Row) -> tuple[str, int, int, float | None, float, float]:
    score, value = (np.asarray(row[f"critic_{one}"]) for one in ("scores", "robustness"))
    best = np.argsort(-score)[: max(1, round(BEST * score.size))]
    rank = spearman(score, value)
    return (
        row["task"],
        row["seed"],
        int(score.size),
        None if np.isnan(rank) else float(rank),
        float((value >= 0).mean()),
        float((value[best] >= 0).mean()),
    )
