"""What the constants of rough cameras become at a frame rate."""

import numpy as np
import pytest

from vbbench_baselines.joint_map.prior import stationary, unbounded
from vbbench_baselines.joint_map.real_camera.settings import REFERENCE, Settings

FRAME_TIMES = np.geomspace(0.001, 10.0, 41)


@pytest.mark.parametrize("cold", [False, True])
def test_walks_are_steady_at_any_frame_rate(cold: bool) -> None:
    for dt in FRAME_TIMES:
        walk = Settings().walk(float(dt), cold)
        assert np.isfinite(walk.filters).all()
        assert np.isfinite(walk.spreads).all()
        assert (walk.spreads > 0.0).all()
        assert walk.nu >= 1.0
        assert 0.0 < walk.sigma < np.inf


def test_the_constants_are_those_of_the_reference_frame_time() -> None:
    settings = Settings()
    walk = settings.walk(REFERENCE, False)
    b1, b2 = settings.walk_b
    np.testing.assert_allclose(walk.filters[-1], [1.0, -2.0 - b1, 1.0 + 2.0 * b1 - b2, 2.0 * b2 - b1, -b2], atol=1e-12)
    assert walk.sigma == pytest.approx(settings.walk_std)
    assert walk.nu == pytest.approx(settings.walk_nu)


def test_people_come_back_sooner_where_frames_are_close() -> None:
    """What changes from frame to frame comes back: the sum of b, by which a jerk is undone, falls with dt."""
    sums = []
    for dt in (0.4, 0.2, 0.1, 0.05):
        filters = Settings().walk(dt, False).filters[-1]
        sums.append(-2.0 - filters[1] - filters[4])
    assert (np.diff(sums) < 0.0).all()


def test_partial_autocorrelations_tell_the_same() -> None:
    for b in ((-0.35, -0.1), (0.9, -0.4), (-1.2, -0.5), (0.0, 0.0)):
        np.testing.assert_allclose(stationary(unbounded(b)), b, atol=1e-12)
