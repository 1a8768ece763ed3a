"""The read-out of a heatmap: values are sent in attributes, a fixed script shows them."""

import json
from collections.abc import Callable, Sequence

import numpy as np

from core.heatmap import Heatmap
from studio.page.figures import svg

SCALE = 65535
"""Values are sent as four hexadecimal digits between the least and the largest."""


def cell_under_pointer(columns: int, rows: int) -> str:
    """JavaScript that finds `column` and `row`, the row counted from below."""
    return (
        "const box=this.getBoundingClientRect(),"
        "cell=(f,n)=>Math.min(n-1,Math.max(0,Math.floor(f*n))),"
        f"column=cell((event.clientX-box.left)/box.width,{columns}),"
        f"row=cell((box.bottom-event.clientY)/box.height,{rows});"
    )


def show_cell() -> str:
    """JavaScript that writes the cell `column`, `row` into the read-out below the map."""
    return (
        "const d=this.dataset,xs=JSON.parse(d.first),ys=JSON.parse(d.second),"
        "names=JSON.parse(d.names),i=row*xs.length+column,hex=(s,n)=>parseInt(s.substr(n*i,n),16),"
        "at=names.map((name,k)=>name+' = '+(k?ys[row]:xs[column])).join(', '),"
        f"v=Number(d.low)+(d.high-d.low)*hex(d.values,4)/{SCALE},"
        "why=JSON.parse(d.reasons)[hex(d.reason,3)],"
        "found=d.robustness?d.robustness.split(',')[i]+', ':'';"
        "this.closest('.tg-map').querySelector('.tg-readout').textContent="
        "at+': '+found+'value '+v.toFixed(2)+(why?'; ruled out: '+why:'');"
    )


def cell_data(
    heatmap: Heatmap,
    names: Sequence[str],
    tolerance: float,
    reason: Callable[[int, int], str] | None,
    robustness: np.ndarray | None = None,
) -> str:
    """Attributes with the axes' values, the critic's, and why cells are ruled out.

    With the robustness [h, w] of the cells' rollouts [m], that too.
    """
    low, high, digits = _packed(heatmap.values)
    reasons, codes = _reasons(heatmap, tolerance, reason)
    found = {
        "names": json.dumps(list(names)),
        "first": json.dumps(heatmap.first.tolist()),
        "second": json.dumps(heatmap.second.tolist()),
        "low": f"{low:.4f}",
        "high": f"{high:.4f}",
        "values": digits,
        "reasons": json.dumps(reasons),
        "reason": codes,
    }
    if robustness is not None:
        found["robustness"] = ",".join(map(_found, robustness.ravel()))
    return " ".join(f'data-{name}="{svg.escape(text)}"' for name, text in found.items())


def _found(robustness: float) -> str:
    """What simulation found, without a comma."""
    if np.isnan(robustness):
        return "not simulated yet"
    if not np.isfinite(robustness):
        return "fails: the simulation broke down"
    return f"{'satisfied' if robustness >= 0 else 'fails'} with robustness {robustness:.3f} m"


def _packed(values: np.ndarray) -> tuple[float, float, str]:
    finite = values[np.isfinite(values)]
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 0.0)
    share = (np.nan_to_num(values, nan=low) - low) / max(high - low, 1e-9)
    whole = np.clip(share, 0, 1) * SCALE
    return low, high, whole.round().astype(">u2").tobytes().hex()


def _reasons(
    heatmap: Heatmap, tolerance: float, reason: Callable[[int, int], str] | None
) -> tuple[list[str], str]:
    """The distinct reasons, first that of cells not ruled out, and their index by cell."""
    known: dict[str, int] = {"": 0}
    codes = np.zeros(heatmap.shortfall.shape, int)
    if reason is not None:
        for row, column in np.argwhere(heatmap.shortfall > tolerance):
            code = known.setdefault(reason(row, column), len(known))
            codes[row, column] = code if code < 0x1000 else 0
    return list(known), "".join(f"{code:03x}" for code in codes.ravel())
