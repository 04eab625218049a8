"""Joint errors by hand."""

from __future__ import annotations

import numpy as np
import pytest

from halfphysics import metrics
from halfphysics.errors import InputError
from support.point_bodies import Cloud, Drift


@pytest.fixture
def cloud() -> Cloud:
    return Cloud(np.random.default_rng(0).uniform(-0.5, 0.5, (200, 3)))


def _line(frames: int) -> Drift:
    return Drift(np.linspace([-1.0, 0.0, 0.0], [1.0, 0.2, 0.1], frames))


def test_joint_errors_by_hand(cloud: Cloud) -> None:
    a, b = _line(7), _line(7)
    assert metrics.mpjpe(a, b, cloud) == metrics.mpjpe_global(a, b, cloud) == 0.0
    b.translation[:, 0] += np.arange(7) * 0.001
    assert metrics.mpjpe_global(a, b, cloud) == pytest.approx(3.0)
    assert metrics.mpjpe(a, b, cloud) == pytest.approx(0.0, abs=1e-10)

    class Bent(Cloud):
        def joints(self, motion: Drift) -> np.ndarray:
            joints = super().joints(motion).copy()
            if motion is b:
                joints[:, 5] += [0.0, 0.055, 0.0]
                joints[:, 0] += [0.011, 0.0, 0.0]
            return joints

    b.translation[:] = a.translation
    bent = Bent(cloud.points)
    assert metrics.mpjpe_global(a, b, bent) == pytest.approx((55 + 11) / 55)
    # Subtracting the pelvis moves the other 54 joints by its 11 mm.
    assert metrics.mpjpe(a, b, bent) == pytest.approx((53 * 11 + np.hypot(55, 11)) / 55)


def test_motions_that_cannot_be_compared(cloud: Cloud) -> None:
    with pytest.raises(InputError, match=r"found 7 and 8 frames; cut .* or resample"):
        metrics.mpjpe(_line(7), _line(8), cloud)
    with pytest.raises(InputError, match="found 30 and 60 fps"):
        metrics.mpjpe_global(_line(7), Drift(_line(7).translation, 60.0), cloud)
