"""The figures of one dance that was put together, keys as the contracts have them."""

from typing import Any

import numpy as np

from live.cli.dance_plan import Plan


def path_figures(plan: Plan) -> dict[str, Any]:
    """How far she is from her path at the measure ends, place [m] and heading [degrees]; empty without a path."""
    followed = plan.followed
    if followed is None:
        return {"path_error_m": _listed(np.zeros(0)), "heading_error_deg": _listed(np.zeros(0))}
    return {
        "path_error_m": _listed(followed.error),
        "heading_error_deg": _listed(np.degrees(followed.heading_error)),
    }


def _listed(values: Any) -> dict[str, Any]:
    return {
        "list": [round(float(value), 4) for value in values],
        "p95": float(np.percentile(values, 95)) if len(values) else None,
    }
