"""The fitted motion priors: that the fit finds what walks were made of, and what the committed values stand on."""

import tomllib
from dataclasses import replace
from importlib.resources import files

import numpy as np
import pytest

from vbbench.errors import UnknownNameError, VbbenchError
from vbbench.registry import make_solver
from vbbench.scene import Scene
from vbbench_baselines.joint_map import fit as fitting
from vbbench_baselines.joint_map.fit import fit, main, to_toml
from vbbench_baselines.joint_map.prior import PRIORS, Prior, get_prior
from vbbench_baselines.joint_map.priors.turns import fit_cauchy
from vbbench_baselines.joint_map.priors.walks import fit_walks, gather, innovations, log_likelihood

MADE = Prior(b=(-0.5, -0.2), sigma=0.06, nu=5.0, a0=6.0)


def made_scene(prior: Prior, people: int, frames: int, seed: int = 0) -> Scene:
    """Walks drawn from a prior, all of them away from where they began."""
    rng = np.random.default_rng(seed)
    spread = np.sqrt(prior.a0 * prior.sigma**2 / rng.chisquare(prior.a0, people))
    tails = np.sqrt(prior.nu / rng.chisquare(prior.nu, (frames + 20, people)))
    e = rng.normal(size=(frames + 20, people, 2)) * (tails * spread)[..., None]
    a = np.zeros_like(e)
    for t in range(2, len(e)):
        a[t] = prior.b[0] * a[t - 1] + prior.b[1] * a[t - 2] + e[t]
    velocity = np.array((0.5, 0.0)) + np.cumsum(a[20:], axis=0)
    return Scene(
        name="made",
        dt=prior.dt,
        people=np.arange(people),
        positions=np.cumsum(velocity, axis=0),
        heights=np.full(people, 1.7),
    )


@pytest.mark.slow
def test_fit_finds_what_walks_were_made_of():
    fitted = fit_walks([gather([made_scene(MADE, 600, 25)])], Prior(), 3.0)
    assert fitted.b == pytest.approx(MADE.b, abs=0.03)
    assert fitted.sigma == pytest.approx(MADE.sigma, rel=0.05)
    assert fitted.nu == pytest.approx(MADE.nu, rel=0.2)
    assert fitted.a0 == pytest.approx(MADE.a0, rel=0.25)


@pytest.mark.slow
def test_density_integrates_to_one():
    """Over the plane of a first second difference, whose logarithm's mean `log_likelihood` is."""
    edge = np.linspace(-4.0, 4.0, 81)
    grid = np.stack(np.meshgrid(edge, edge), -1).reshape(-1, 2)
    walks = gather([made_scene(MADE, 2, 3)])
    one = walks._replace(order=np.zeros(1, np.int64), first=np.zeros(1, np.int64))
    wide = replace(MADE, sigma=0.3)
    density = [np.exp(log_likelihood(one._replace(differences=np.array([[a, (0, 0), (0, 0)]])), wide)) for a in grid]
    assert np.sum(density) * (edge[1] - edge[0]) ** 2 == pytest.approx(1.0, abs=0.01)


@pytest.mark.slow
def test_a_walk_begins_as_it_goes_on():
    """Innovations in units of their scale have the same spread in a walk's first steps as later."""
    walks = gather([made_scene(replace(MADE, nu=100.0, a0=200.0), 20_000, 5)])
    squares = innovations(walks, MADE)
    means = [squares[walks.order == order].mean() for order in range(3)]
    assert means == pytest.approx([2 * MADE.sigma**2] * 3, rel=0.05)


def test_gaps_end_a_walk_and_those_who_stand_are_left_out():
    positions = np.zeros((8, 2, 2))
    positions[:, 0, 0] = np.arange(8.0)
    positions[4, 0] = np.nan
    positions[:, 1] = np.random.default_rng(1).normal(0.0, 0.01, (8, 2))
    scene = Scene(name="s", dt=0.4, people=np.arange(2), positions=positions, heights=np.full(2, 1.7))
    walks = gather([scene])
    assert walks.order.tolist() == [0, 1, 0]
    assert walks.first.tolist() == [0]


def test_cauchy_scale_is_found():
    rng = np.random.default_rng(0)
    assert fit_cauchy([0.05 * rng.standard_cauchy(20_000)]) == pytest.approx(0.05, rel=0.05)


@pytest.mark.slow
def test_interpolated_truth_is_not_believed():
    """Straight lines between key points: without the bound, ν falls as far as it can."""
    made = made_scene(MADE, 60, 31)
    positions = made.positions.copy()
    for t in range(30):
        before = t - t % 10
        positions[t] = made.positions[before] + (t - before) / 10 * (
            made.positions[before + 10] - made.positions[before]
        )
    walks = gather([replace(made, positions=positions)])
    assert fit_walks([walks], Prior(), 3.0).nu == pytest.approx(3.0)
    assert fit_walks([walks], Prior(), 0.2).nu < 1.0


@pytest.mark.parametrize("name", PRIORS)
def test_committed_priors_say_what_they_stand_on(name):
    prior = get_prior(name)
    text = (files("vbbench_baselines") / "joint_map" / "priors" / f"{name}.toml").read_text("utf-8")
    assert text.startswith("# Written by: python -m vbbench_baselines.joint_map.fit")
    splits = [split["split"] for split in tomllib.loads(text)["fitted_on"]]
    assert splits
    assert name.removeprefix("without-") not in splits
    assert prior.nu >= 3.0
    assert np.abs(np.roots((1.0, *(-b for b in prior.b)))).max() < 1.0


@pytest.mark.parametrize("kind", ["Causal", "Batch"])
@pytest.mark.parametrize("prior", ["without-hotel", "without-eth"])
def test_solvers_with_a_prior_left_out_can_be_named(kind, prior):
    name = kind + prior.title().replace("-", "")
    solver = make_solver(f"vbbench_baselines.joint_map.priors.left_out:{name}")
    assert solver.prior == get_prior(prior)


def test_other_frame_rates():
    prior = replace(MADE, yaw_scale=0.04)
    slow = prior.at(0.8)
    assert (slow.dt, slow.b, slow.nu) == (0.8, prior.b, prior.nu)
    assert (slow.sigma, slow.yaw_scale) == pytest.approx((4 * prior.sigma, 2 * prior.yaw_scale))
    assert prior.at(prior.dt) == prior


def test_faults(capsys):
    with pytest.raises(UnknownNameError, match="did you mean 'without-eth'"):
        get_prior("without-et")
    with pytest.raises(VbbenchError, match="no split"):
        fit([])
    with pytest.raises(SystemExit) as left:
        main(["sim", "--leave-out", "sim"])
    assert left.value.code == 2
    assert "no split" in capsys.readouterr().err


def cached(function):
    """Calls it once for the same arguments, which need not be hashable."""
    answers = {}

    def answer(*arguments, **options):
        key = repr((arguments, options))
        if key not in answers:
            answers[key] = function(*arguments, **options)
        return answers[key]

    return answer


@pytest.mark.slow
def test_command_writes_what_it_prints(capsys, monkeypatch, tmp_path):
    monkeypatch.setattr(fitting, "SIMULATED", 16)
    monkeypatch.setattr(fitting, "OBSERVERS", 16)
    monkeypatch.setattr(fitting, "fit", cached(fitting.fit))  # it takes most of a minute
    main(["sim", "--seed", "7", "--out", str(tmp_path / "p.toml")])
    main(["sim", "--seed", "7"])
    text = capsys.readouterr().out
    assert (tmp_path / "p.toml").read_text("utf-8") == text
    assert tomllib.loads(text)["fitted_on"][0]["seed"] == 7


@pytest.mark.slow
def test_recordings_give_the_committed_values(data_folder):
    prior, facts = fit(["eth"])
    committed = (files("vbbench_baselines") / "joint_map" / "priors" / "without-hotel.toml").read_text("utf-8")
    written = tomllib.loads(to_toml(prior, facts, "here"))
    assert written == tomllib.loads(committed)
