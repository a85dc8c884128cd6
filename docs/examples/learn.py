"""A network of 8,000 weights that finds the camera and the people around it, trained on simulated crowds.

Points on the ground are complex numbers: forward − i·right from the camera, x + i·y in the world. A pose is a place and
a heading e^(i·yaw); what is at q from the camera is at place + heading·q in the world.
"""

from pathlib import Path

import numpy as np
import torch
from torch import nn

from vbbench import Frame, FrameEstimate, Problem
from vbbench.generation.generator import Options
from vbbench.training import GeneratedSamples
from vbbench.training.torch import Feed

WEIGHTS = Path(__file__).with_name("learned.pt")


def point(values):
    """(x, y) [..., 2] as complex numbers [...]."""
    return torch.complex(values[..., 0], values[..., 1])


def sight(values):
    """(right, forward) [..., 2] as complex numbers [...]."""
    return torch.complex(values[..., 1], -values[..., 0])


def split(values, across, along):
    """The parts of complex values, each times its own gain."""
    return torch.complex(values.real * across, values.imag * along)


class Birdifier(nn.Module):
    """Expects everybody to walk on, looks at who is off, decides whom to trust, and fits the pose to them."""

    def __init__(self, width=48):
        super().__init__()
        self.look = nn.Sequential(nn.Linear(11, width), nn.ReLU(), nn.Linear(width, width), nn.ReLU())
        self.trust = nn.Sequential(nn.Linear(2 * width, width), nn.ReLU(), nn.Linear(width, 6))
        self.inertia = nn.Linear(width, 2)

    def begin(self, batch, people):
        """The state before frame 0: where everybody is, how they walk, how often they were seen, how tall they are."""
        one, everyone = torch.zeros(batch, dtype=torch.complex64), torch.zeros(batch, people, dtype=torch.complex64)
        state = {"place": one, "heading": one + 1, "stride": one, "at": everyone, "walk": everyone}
        return state | {"age": torch.zeros(batch, people), "size": torch.ones(batch, people)}

    def step(self, state, seen, sights, given, is_given, pose, pose_given):
        """The state after a frame with these sights and given places [B, K], and the pose (place, heading) if given."""
        place, heading, age = state["place"] + state["stride"], state["heading"], state["age"]
        known = seen & (is_given | (age > 0))
        expected = torch.where(is_given, given, state["at"] + state["walk"])
        sights = sights * state["size"]
        far = sights.abs().clamp(min=0.3)
        ray = torch.where(seen, sights / far, 1.0)

        def off_from(place, heading):  # how far each sight is off what is expected: along its ray, and across
            return (sights - (expected - place[:, None]) * heading[:, None].conj()) * ray.conj()

        off = torch.where(known, off_from(place, heading), 0.0)
        walk, stride = state["walk"] * heading[:, None].conj(), (state["stride"] * heading.conj())[:, None]
        facts = [part for number in (off, ray, walk, stride.expand_as(ray)) for part in (number.real, number.imag)]
        each = self.look(torch.stack([*facts, far.log(), is_given.float(), (age == 1).float()], -1)) * known[..., None]
        mean = each.sum(1) / known.sum(1, keepdim=True).clamp(min=1)
        trust = self.trust(torch.cat([each, mean[:, None].expand_as(each)], -1))
        weight, gain = nn.functional.softplus(trust[..., 0]) * known, trust[..., 1:].sigmoid()
        inertia = self.inertia(mean).exp()
        cross = torch.tensor([1, 1j, -1, -1j]) * inertia[:, 1:]  # four points about the expected pose hold it there
        turn, middle, centre = fit(
            torch.cat([sights - ray * off.real * (1 - gain[..., 0]), cross], 1),
            torch.cat([expected, place[:, None] + heading[:, None] * cross], 1),
            torch.cat([weight, inertia[:, :1].expand(-1, 4)], 1),
        )
        heading = torch.where(pose_given, pose[1], turn)
        place = torch.where(pose_given, pose[0], centre - middle * heading)

        off, steer = off_from(place, heading), heading[:, None] * ray
        at = expected + steer * split(off, gain[..., 1], gain[..., 2])
        pace = state["walk"] + steer * split(off, gain[..., 3], gain[..., 4])
        at = torch.where(age > 0, at, place[:, None] + heading[:, None] * sights)
        at = torch.where(is_given, given, at)
        pace = torch.where(age == 1, at - state["at"], torch.where(age > 0, pace, 0.0))
        size = ((given - place[:, None]).abs() / far).clamp(0.7, 1.4) * state["size"]
        size = torch.where(age > 0, 0.5 * (state["size"] + size), size)
        return {
            "place": place,
            "heading": heading,
            "stride": place - state["place"],
            "at": torch.where(seen, at, state["at"] + state["walk"]),
            "walk": torch.where(seen, pace, state["walk"]),
            "age": age + seen,
            "size": torch.where(is_given, size, state["size"]),
        }

    def forward(self, batch):
        """Places [B, T] and headings [B, T] of the camera, and places [B, T, K] of people."""
        sights, given, own = sight(batch.sights), point(batch.given_positions), point(batch.given_poses)
        headings = torch.polar(torch.ones_like(own.real), batch.given_poses[..., 2])
        state, answers = self.begin(*batch.tracks.shape), []
        for t in range(batch.frames.shape[1]):
            told = given[:, t], batch.position_given[:, t], (own[:, t], headings[:, t]), batch.pose_given[:, t]
            state = self.step(state, batch.seen[:, t], sights[:, t], *told)
            answers.append([state["place"], state["heading"], state["at"]])
        return [torch.stack(answer, 1) for answer in zip(*answers)]


def fit(sights, places, weights):
    """The turn e^(i·yaw) [B] that best puts sights on places [B, K], and the middles [B] of both: in closed form."""
    share = weights / weights.sum(1, keepdim=True)
    middle, centre = (share * sights).sum(1, keepdim=True), (share * places).sum(1, keepdim=True)
    turn = (share * (places - centre) * (sights - middle).conj()).sum(1)
    return turn / turn.abs().clamp(min=1e-6), middle[:, 0], centre[:, 0]


def errors(net, batch):
    """Errors of what is scored: of the camera in m and rad, of people in m."""
    place, heading, people = net(batch)
    true = torch.polar(torch.ones_like(place.real), batch.poses[..., 2])
    camera, turn, others = place - point(batch.poses), heading - true, people - point(batch.positions)
    return camera.abs()[batch.scored_poses], turn.abs()[batch.scored_poses], others.abs()[batch.scored_positions]


def train(steps=300, batch_size=32, workers=2):
    """Train on the crowds of seed 2, look at those of seed 1 now and then, and write the weights."""
    torch.manual_seed(0)
    torch.set_num_threads(1)  # the other cores make crowds
    made = {seed: GeneratedSamples("sim", Options(tier="noisy", seed=seed), local=True) for seed in (1, 2)}
    held_out = next(iter(Feed(made[1], 64)))
    net = Birdifier()
    optimiser = torch.optim.Adam(net.parameters())
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, 6e-3, total_steps=steps)
    for number, batch in zip(range(1, steps + 1), Feed(made[2], batch_size, workers=workers)):
        loss = sum(weight * torch.log1p(5 * wrong).mean() for weight, wrong in zip((1, 2, 1), errors(net, batch)))
        optimiser.zero_grad()
        loss.backward()
        nn.utils.clip_grad_norm_(net.parameters(), 1.0)
        optimiser.step()
        schedule.step()
        if number == 1 or number % max(1, steps // 8) == 0:
            with torch.no_grad():
                camera, turn, others = (wrong.mean() for wrong in errors(net, held_out))
            print(f"{number:4} loss {loss:.3f}, held out: camera {camera:.3f} m, {turn:.3f} rad, people {others:.3f} m")
    torch.save(net.state_dict(), WEIGHTS)


class Learned:
    """The network as a solver: vbbench solve DATASET --solver learn:Learned."""

    def __init__(self):
        self.net = Birdifier()
        self.net.load_state_dict(torch.load(WEIGHTS, weights_only=True))

    def start(self, problem: Problem) -> None:
        self.problem, self.origin = problem, None
        self.state = self.net.begin(1, len(problem.tracks))

    @torch.no_grad()
    def step(self, frame: Frame) -> FrameEstimate:
        if self.origin is None:  # a world that begins here, so that float32 is exact enough
            self.origin = np.append(frame.given.poses[2, :2], 0.0)
        heights = np.full(len(frame.observations), self.problem.height_mean)
        seen, sights = known(self.problem.camera.unproject(frame.observations, heights))
        is_given, given = known(frame.given.positions[2] - self.origin[:2])
        pose_given, pose = known(frame.given.poses[2:] - self.origin)
        told = point(given)[None], is_given[None], (point(pose), torch.polar(torch.ones(1), pose[:, 2])), pose_given
        self.state = self.net.step(self.state, seen[None], sight(sights)[None], *told)
        place, people = (torch.view_as_real(self.state[name][0]).numpy() for name in ("place", "at"))
        pose = np.append(place, self.state["heading"][0].angle()) + self.origin
        return FrameEstimate(pose=pose, positions=people + self.origin[:2])


def known(values):
    """Whether each of [N, M] is known, and all as a tensor with 0 where they are not."""
    there = ~np.isnan(values).any(-1)
    return torch.from_numpy(there), torch.from_numpy(np.nan_to_num(values)).float()


if __name__ == "__main__":
    train()
