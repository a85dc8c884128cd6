// One frame through the learned network: what `network.py` trains, for one sequence, in float.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "elementary.hpp"
#include "layers.hpp"
#include "pose_fit.hpp"

namespace vbbench::former {

constexpr int kTraces = 4, kMemory = 24, kDoubt = 12;
constexpr int kWalkFacts = 14, kEgoFacts = 9, kPersonFacts = 45, kObserverFacts = 29, kLookFacts = 8;
constexpr float kLongest = 40.0f, kFar = 1e4f;
constexpr float kNearestLog = -1.6f, kFarthestLog = 4.8f;

/// The state of a person, with the fields and layout of `state.Walkers`.
struct Walker {
  Point place, place_before, velocity;
  std::array<Point, kTraces> traces;
  std::array<float, kMemory> memory;
  std::array<float, 2> offsets;
  float seen, away, shown, traceable, exact, exact_before, by_height, by_feet, has_feet;
};

/// The state of the observer, with the fields of `state.Observer`.
struct Observer {
  Point step;
  float turn;
  Point velocity;
  float turn_rate;
  Point smooth;
  float head_odds;
  std::array<Point, kTraces> traces;
  std::array<float, kMemory> memory;
  std::array<float, kDoubt> doubt;
  float moved, told, frames;
};

/// A person's measurement and given place, with the fields of `sights.Sights` and `scene.Told`.
struct Sight {
  float seen;
  Point ray;
  float by_height, by_feet, has_feet;
  std::array<float, 3> noise, cut;
  Point place;
  float placed;
};

/// The observer's given motion and odometry, with the fields of `scene.Told`.
struct Given {
  Point step;
  float turn, moved;
  Point measured_step;
  float measured_turn;
  std::array<float, 3> information;
  float sure;
};

/// The answer's motions and its spread, with the fields of `network.Answer`.
struct PoseAnswer {
  Point step;
  float turn;
  Point rough_step;
  float rough_turn;
  std::array<float, 3> spread;
};

struct PersonAnswer {
  Point place;
  std::array<float, 2> spread;
};

constexpr int kFloats = sizeof(float);
constexpr int kWalkerFloats = sizeof(Walker) / kFloats, kObserverFloats = sizeof(Observer) / kFloats;
constexpr int kSightFloats = sizeof(Sight) / kFloats, kGivenFloats = sizeof(Given) / kFloats;
constexpr int kPoseAnswerFloats = sizeof(PoseAnswer) / kFloats, kPersonAnswerFloats = sizeof(PersonAnswer) / kFloats;

class Network {
 public:
  Network(const Weights& weights, bool heads)
      : pure_(weights.has("own_trust.bias", {9})),
        heads_(heads),
        walk_(weights, "walk", kWalkFacts + kMemory, kWidth, 4 + 2 * kTraces),
        own_walk_(weights, "own_walk", kEgoFacts + kMemory, 32, 3 + 2 * kTraces),
        person_(weights, "person", kPersonFacts + kMemory, kWidth, kWidth),
        observer_(weights, "observer", kObserverFacts + kMemory, kWidth, kWidth),
        place_spread_(weights, "place_spread", kWidth + kDoubt + 4, 24, 2),
        after_(weights, "after"),
        trust_(weights, "trust", kWidth, 5),
        own_trust_(weights, "own_trust", kWidth, pure_ ? 9 : 6),
        look_again_(weights, "look_again", kWidth + kLookFacts, kWidth),
        together_(weights, "together", 2 * kWidth, kWidth),
        trust_again_(weights, "trust_again", kWidth, 6),
        doubt_(weights, "doubt", kWidth + kMemory, 32),
        pose_spread_(weights, "pose_spread", kDoubt, 3),
        memory_(weights, "memory", kWidth + 4, kMemory),
        own_memory_(weights, "own_memory", kWidth + 6, kMemory),
        doubts_(weights, "doubts", 32 + 4, kDoubt) {
    for (int block = 0; block < kBlocks; ++block) blocks_.emplace_back(weights, "block" + std::to_string(block));
  }

  /// Updates the state of people [K] and observer by a frame of `dt` s, and writes the answers [K].
  void advance(Walker* people, Observer& observer, int count, const Sight* sights, const Given& given, float dt,
               float spread, PoseAnswer& pose, PersonAnswer* places) const {
    Frame frame(people, observer, count, sights, given, dt, spread);
    take_in_walks(frame);
    foresee(frame);
    attend(frame);
    first_pose(frame);
    find(frame);
    remember(frame);
    answer(frame, pose, places);
    state_after(frame);
  }

 private:
  /// A person in a frame; step 1 updates velocity, traces and offsets of `walker`.
  struct Person {
    Walker walker;
    Sight sight;
    float begins, known, distance, distance_std, box_along, box_across, along, across;
    std::array<float, 2> gains;
    Point place, off;  ///< of the answer
    bool given;
  };

  struct Frame {
    Frame(Walker* before, Observer& observer, int count, const Sight* sights, const Given& of_frame, float seconds,
          float of_heights)
        : people(count),
          views(count),
          remembered(before),
          own(observer),
          own_after(observer),
          given(of_frame),
          measured{{given.measured_step, given.measured_turn}, given.information, given.sure},
          dt(seconds),
          spread(of_heights),
          scale(0.4f * seconds),
          rows(count + 1, kWidth),
          thoughts(count, kWidth),
          memories(count, kMemory) {
      for (int k = 0; k < count; ++k) {
        people[k].walker = before[k];
        people[k].sight = sights[k];
      }
    }

    int count() const { return static_cast<int>(people.size()); }
    Motion or_given(const Motion& found) const { return given.moved > 0.5f ? Motion{given.step, given.turn} : found; }

    std::vector<Person> people;
    std::vector<View> views;
    Walker* remembered;
    Observer own;  ///< step 1 updates velocity, turn rate, traces and head
    Observer& own_after;
    const Given& given;
    Measured measured;
    float dt, spread, scale;
    float own_begins = 0.0f, known = 0.0f, seen = 0.0f;
    std::array<float, 3> own_surprise{}, inertia{}, uncertain{};
    Motion expected, rough, motion;
    Weighing weighing;
    Rows rows;      ///< hidden features of people and, last, the observer
    Rows thoughts;  ///< hidden features of people given the first pose
    Rows memories;  ///< memories of people after the frame
    std::vector<float> own_row, own_memory, doubt;
  };

  /// Writes facts one after the other.
  struct Writer {
    explicit Writer(float* place) : at(place) {}
    void put(float value) { *at++ = value; }
    void put(Point point) { put(point.x), put(point.y); }
    template <std::size_t n>
    void put(const std::array<float, n>& values) {
      for (const float value : values) put(value);
    }
    void put(const float* values, int n) {
      for (int i = 0; i < n; ++i) put(values[i]);
    }
    float* at;
  };

  static Point asinh(Point a) { return {elementary::asinh(a.x), elementary::asinh(a.y)}; }
  static Point clipped(Point a) { return {clip(a.x, -3.0f, 3.0f), clip(a.y, -3.0f, 3.0f)}; }

  /// Step 1: each velocity is corrected by a share of the last innovation.
  void take_in_walks(Frame& frame) const {
    const int count = frame.count();
    const float log_dt = elementary::log(frame.dt);
    struct News {
      Point toward, strange, off;
      float fresh;
      std::array<float, 2> farther;
    };
    std::vector<News> news(count);
    Rows facts(count, kWalkFacts + kMemory);
    for (int k = 0; k < count; ++k) {
      Person& person = frame.people[k];
      const Walker& w = person.walker;
      News& n = news[k];
      const float kept = std::sqrt(squared(w.place) + 1e-4f);
      n.toward = w.place / kept;
      n.fresh = w.shown * w.traceable;
      n.strange = (w.place - w.place_before) / frame.dt - w.velocity;
      n.off = n.strange * conj(n.toward);
      person.begins = w.seen < 2.5f ? n.fresh : 0.0f;
      n.farther = {(clip(elementary::log(kept) - w.by_height, -0.5f, 0.5f) - w.offsets[0]) * w.shown,
                   (clip(elementary::log(kept) - w.by_feet, -0.5f, 0.5f) - w.offsets[1]) * (w.shown * w.has_feet)};
      Writer row(facts[k]);
      row.put(asinh(n.off * 2.0f));
      row.put(w.velocity * conj(n.toward));
      row.put(n.off * 0.3f);
      row.put(std::array{5.0f * n.farther[0], 5.0f * n.farther[1], person.begins, w.exact, w.exact_before,
                         elementary::log(1.0f + w.seen), elementary::log(kept), log_dt});
      row.put(w.memory);
    }
    const Rows gates = walk_(facts);
    for (int k = 0; k < count; ++k) {
      Person& person = frame.people[k];
      Walker& w = person.walker;
      const News& n = news[k];
      const float* gate = gates[k];
      const float ahead = sigmoid(gate[0] + 4.0f * person.begins) * n.fresh;
      const float across = sigmoid(gate[1] + 4.0f * person.begins) * n.fresh;
      w.velocity = w.velocity + Point{ahead * n.off.x, across * n.off.y} * n.toward;
      for (int i = 0; i < 2; ++i) w.offsets[i] += sigmoid(gate[2 + i]) * n.farther[i];
      for (int i = 0; i < kTraces; ++i) {
        const float kept = 1.0f - n.fresh * (1.0f - sigmoid(gate[4 + i]));
        const float added = elementary::tanh(gate[4 + kTraces + i]) * n.fresh * (1.0f - person.begins);
        w.traces[i] = w.traces[i] * kept + n.strange * added;
      }
    }
    take_in_own_walk(frame, log_dt);
  }

  void take_in_own_walk(Frame& frame, float log_dt) const {
    Observer& own = frame.own;
    const Point strange = own.step - own.velocity;
    const float turned = own.turn - own.turn_rate;
    frame.own_begins = own.frames < 2.5f ? 1.0f : 0.0f;
    frame.own_surprise = {elementary::asinh(2.0f * strange.x), elementary::asinh(2.0f * strange.y),
                          elementary::asinh(2.0f * turned)};
    std::vector<float> facts(kEgoFacts + kMemory);
    Writer row(facts.data());
    row.put(frame.own_surprise);
    row.put(own.velocity);
    row.put(std::array{own.turn_rate, frame.own_begins, own.told, log_dt});
    row.put(own.memory);
    const auto gate = own_walk_(facts);
    std::array<float, 3> gains;
    for (int i = 0; i < 3; ++i) gains[i] = sigmoid(gate[i] + 4.0f * frame.own_begins) * own.moved;
    for (int i = 0; i < kTraces; ++i) {
      const float kept = 1.0f - own.moved * (1.0f - sigmoid(gate[3 + i]));
      const float added = elementary::tanh(gate[3 + kTraces + i]) * (own.moved * (1.0f - frame.own_begins));
      own.traces[i] = own.traces[i] * kept + strange * added;
    }
    const Point smoothed = own.smooth + (own.step - own.smooth) * heads::gain(frame.dt);
    own.smooth = (own.frames < 2.5f ? own.step : smoothed) * own.moved;
    if (!(own.frames < 3.5f)) own.head_odds = heads::odds_after(own.head_odds, own.smooth, own.turn, frame.dt);
    own.velocity = own.velocity + Point{gains[0] * strange.x, gains[1] * strange.y};
    own.turn_rate += gains[2] * turned;
  }

  /// Step 2: constant velocity predicts all places, and a plain robust fit gives an approximate motion of the camera.
  void foresee(Frame& frame) const {
    constexpr float kWalk = 0.15f, kExact = 0.01f, kOwnWalk = 0.3f, kOwnTurn = 1.5f;
    const float dt = frame.dt;
    for (int k = 0; k < frame.count(); ++k) {
      Person& p = frame.people[k];
      const Walker& w = p.walker;
      const Sight& s = p.sight;
      p.given = s.placed > 0.5f;
      const float stature = frame.spread / std::sqrt(1.0f + w.seen);
      const float by_height = 1.0f / (square(s.noise[1]) + square(stature) + 1e-5f);
      const float by_feet = s.has_feet / (square(s.noise[2]) + 1e-5f), total = by_height + by_feet;
      const float measured = by_height * (s.by_height + w.offsets[0]) + by_feet * (s.by_feet + w.offsets[1]);
      p.distance = clip(measured / total, kNearestLog, kFarthestLog);
      p.distance_std = 1.0f / std::sqrt(total);
      const float reach = elementary::exp(p.distance), stray = square(p.given ? kExact : kWalk * dt + kExact);
      p.box_along = p.distance_std * reach;
      p.box_across = s.noise[0] * reach;
      p.along = square(p.box_along) + stray;
      p.across = square(p.box_across) + stray;
      p.known = w.seen > 0.5f || p.given ? s.seen : 0.0f;
      frame.known += p.known;
      frame.seen += s.seen;
      frame.views[k] = {p.given ? s.place : w.place + w.velocity * dt, s.ray * reach, s.ray};
    }
    const float walk = 1.0f / square(kOwnWalk * dt + 0.01f), turn = 1.0f / square(kOwnTurn * dt + 0.05f);
    frame.inertia = {walk, walk, turn};
    frame.expected = {frame.own.velocity * dt, frame.own.turn_rate * dt};
    rough_motion(frame);
  }

  static void rough_motion(Frame& frame) {
    Weighing& plain = frame.weighing;
    plain.inertia = frame.inertia;
    plain.motion = frame.expected;
    add_measured(plain.inertia, plain.motion, frame.measured);
    for (const Person& p : frame.people) plain.people.push_back({p.known / p.along, p.known / p.across, {}});
    std::array<float, 3> variances{};
    Motion rough = fit(frame.views, plain, align(frame.views, plain), 1, variances);
    const Point turned = direction(-rough.turn);
    for (int k = 0; k < frame.count(); ++k) {
      const Person& p = frame.people[k];
      const Point off = seen_after(frame.views[k], rough, turned).off;
      const float doubtful = 1.0f + 0.25f * (square(off.x) / p.along + square(off.y) / p.across);
      plain.people[k].along /= doubtful;
      plain.people[k].across /= doubtful;
    }
    rough = fit(frame.views, plain, rough, 1, variances);
    frame.rough = frame.or_given(rough);
  }

  /// Step 3: people and observer attend to one another.
  void attend(Frame& frame) const {
    const int count = frame.count();
    Rows facts(count, kPersonFacts + kMemory);
    for (int k = 0; k < count; ++k) person_facts(frame, k, Writer(facts[k]));
    const Rows people = person_(facts);
    const auto own = observer_(observer_facts(frame));
    std::copy(people.values.begin(), people.values.end(), frame.rows.values.begin());
    std::copy(own.begin(), own.end(), frame.rows[count]);
    std::vector<float> absent(count + 1, 0.0f);
    for (int k = 0; k < count; ++k) absent[k] = (frame.people[k].sight.seen - 1.0f) * kFar;
    for (const Block& block : blocks_) block.attend(frame.rows, absent);
    frame.rows = after_(frame.rows);
    frame.own_row.assign(frame.rows[count], frame.rows[count] + kWidth);
    frame.rows.values.resize(static_cast<std::size_t>(count) * kWidth);
    frame.rows.count = count;
  }

  static void person_facts(const Frame& frame, int k, Writer row) {
    const Person& p = frame.people[k];
    const Walker &w = p.walker, &before = frame.remembered[k];
    const Sight& s = p.sight;
    const float scale = frame.scale, along = std::sqrt(p.along), across = std::sqrt(p.across);
    const Point off = seen_after(frame.views[k], frame.rough).off;
    const Point off_expected = seen_after(frame.views[k], frame.expected).off;
    row.put(asinh(off / scale) * p.known);
    row.put(asinh(off_expected / scale) * 0.5f * p.known);
    row.put(asinh(Point{off.x / along, off.y / across}) * p.known);
    row.put(clipped(off) * p.known);
    const Point turned = direction(-frame.rough.turn), upright = conj(s.ray);
    row.put(w.velocity * turned * upright);
    row.put(frame.own.velocity * turned * upright);
    for (const Point trace : w.traces) row.put(trace * turned * upright);
    row.put(s.ray);
    row.put(std::array{p.known, s.placed, elementary::log(1.0f + before.seen), elementary::log(1.0f + before.away),
                       p.begins, w.exact, w.exact_before, p.distance});
    for (const float noise : s.noise) row.put(elementary::log(noise + 1e-4f));
    const float apart = clip(s.by_feet + w.offsets[1] - s.by_height - w.offsets[0], -1.0f, 1.0f) * s.has_feet;
    row.put(std::array{elementary::log(p.distance_std + 1e-3f), 5.0f * apart, 5.0f * w.offsets[0], 5.0f * w.offsets[1],
                       s.has_feet, elementary::log(frame.dt), 10.0f * frame.spread});
    row.put(s.cut);
    row.put(std::array{elementary::log(along + 1e-3f), elementary::log(across + 1e-3f)});
    row.put(w.memory);
  }

  static std::vector<float> observer_facts(const Frame& frame) {
    const Observer& own = frame.own;
    const Point beyond = (frame.rough.step - frame.expected.step) / frame.dt;
    const float turned = (frame.rough.turn - frame.expected.turn) / frame.dt;
    std::vector<float> facts(kObserverFacts + kMemory);
    Writer row(facts.data());
    row.put(own.velocity);
    row.put(own.turn_rate);
    row.put(frame.own_surprise);
    row.put(beyond);
    row.put(turned);
    row.put(asinh(beyond * 3.0f));
    row.put(elementary::asinh(3.0f * turned));
    for (const Point trace : own.traces) row.put(trace);
    row.put(std::array{elementary::log(1.0f + frame.known), elementary::log(frame.dt), own.told, frame.own_begins,
                       elementary::log(1.0f + own.frames), 10.0f * frame.spread, 0.05f * frame.seen,
                       frame.known < 1.5f ? 1.0f : 0.0f, frame.known < 2.5f ? 1.0f : 0.0f});
    row.put(own.memory);
    return facts;
  }

  /// Step 4: the weights of the fit, and its motion.
  void first_pose(Frame& frame) const {
    const Rows trust = trust_(frame.rows);
    const auto own_trust = own_trust_(frame.own_row);
    Weighing& weighing = frame.weighing;
    own_prior(frame, own_trust);
    for (int k = 0; k < frame.count(); ++k) {
      const Person& p = frame.people[k];
      const float* t = trust[k];
      weighing.people[k] = {p.known / p.along * elementary::exp(clip(t[2], -6.0f, 5.0f)),
                            p.known / p.across * elementary::exp(clip(t[3], -6.0f, 5.0f)),
                            Point{t[0], t[1]} * (frame.scale * (1.0f - p.sight.placed))};
    }
    weighing.heads = heads_;
    weighing.head = heads::before(frame.own.smooth, frame.own.head_odds, frame.dt);
    frame.motion =
        frame.or_given(pure_ ? weighing.motion : fit(frame.views, weighing, frame.rough, 2, frame.uncertain));
  }

  /// The prior of the fit: weights λ and motion x⁰, with which a pure network answers.
  void own_prior(Frame& frame, const std::vector<float>& trust) const {
    Weighing& weighing = frame.weighing;
    const float dt = frame.dt;
    for (int n = 0; n < 3; ++n)
      weighing.inertia[n] = frame.inertia[n] * elementary::exp(clip(trust[3 + n], -6.0f, 6.0f));
    Motion& said = weighing.motion;
    said.step = frame.expected.step + Point{trust[0], trust[1]} * (0.3f * dt);
    said.turn = frame.expected.turn + trust[2] * (0.5f * dt);
    if (pure_) {
      said.step = said.step + Point{trust[6], trust[7]} * dt;
      said.turn += trust[8] * dt;
    }
    add_measured(weighing.inertia, said, frame.measured);
  }

  /// Steps 4 and 5: the second weights, the pose, and people's places.
  void find(Frame& frame) const {
    look_again(frame);
    const Rows trust = trust_again_(frame.thoughts);
    Weighing& weighing = frame.weighing;
    for (int k = 0; k < frame.count(); ++k) {
      const float* t = trust[k];
      auto& weight = weighing.people[k];
      weight.offset = weight.offset + Point{t[2], t[3]} * (frame.scale * (1.0f - frame.people[k].sight.placed));
      weight.along *= elementary::exp(clip(t[0], -6.0f, 4.0f));
      weight.across *= elementary::exp(clip(t[1], -6.0f, 4.0f));
      frame.people[k].gains = {sigmoid(t[4]), sigmoid(t[5])};
    }
    frame.uncertain = {};
    if (!pure_) {
      frame.motion = fit(frame.views, weighing, frame.motion, 2, frame.uncertain);
      for (float& variance : frame.uncertain) variance = elementary::log(variance + 1e-9f);
    }
    frame.motion = frame.or_given(frame.motion);
    for (int k = 0; k < frame.count(); ++k) place(frame, k);
  }

  static void place(Frame& frame, int k) {
    Person& p = frame.people[k];
    const Seen seen = seen_after(frame.views[k], frame.motion);
    const Point offset = frame.weighing.people[k].offset, left = seen.off - offset;
    const Point moved = seen.place + (offset + Point{p.gains[0] * left.x, p.gains[1] * left.y}) * p.sight.ray;
    const Point unexpected = p.sight.seen > 0.5f ? frame.views[k].seen : seen.place;
    p.place = p.known > 0.5f ? (p.given ? seen.place : moved) : unexpected;
    p.off = seen.off;
  }

  /// Hidden features of people given the first pose; each includes the mean over people.
  void look_again(Frame& frame) const {
    const int count = frame.count();
    Rows facts(count, kWidth + kLookFacts);
    for (int k = 0; k < count; ++k) {
      const Person& p = frame.people[k];
      const Point offset = frame.weighing.people[k].offset;
      const Point off = seen_after(frame.views[k], frame.motion).off - offset;
      Writer row(facts[k]);
      row.put(frame.rows[k], kWidth);
      row.put(asinh(off / frame.scale) * p.known);
      row.put(asinh(Point{off.x / std::sqrt(p.along), off.y / std::sqrt(p.across)}) * p.known);
      row.put(asinh(offset / frame.scale) * p.known);
      row.put(clipped(off) * p.known);
    }
    const Rows again = hidden(look_again_, facts);
    std::array<float, kWidth> mean{};
    for (int k = 0; k < count; ++k)
      for (int i = 0; i < kWidth; ++i) mean[i] += again[k][i] * frame.people[k].known;
    for (float& value : mean) value /= frame.known + 1e-3f;
    Rows both(count, 2 * kWidth);
    for (int k = 0; k < count; ++k) {
      Writer row(both[k]);
      row.put(again[k], kWidth);
      row.put(mean);
    }
    frame.thoughts = hidden(together_, both);
  }

  /// Recurrent memories of people, of the observer and of the pose's error, after the frame.
  void remember(Frame& frame) const {
    const int count = frame.count();
    Rows news(count, kWidth + 4), kept(count, kMemory);
    for (int k = 0; k < count; ++k) {
      const Person& p = frame.people[k];
      Writer row(news[k]);
      row.put(frame.thoughts[k], kWidth);
      row.put(asinh(p.off / frame.scale) * p.known);
      row.put(asinh(frame.weighing.people[k].offset / frame.scale) * p.known);
      Writer(kept[k]).put(p.walker.memory);
    }
    const Rows fresh = memory_.fresh(news), old = memory_.old(kept);
    for (int k = 0; k < count; ++k) {
      if (frame.people[k].sight.seen > 0.5f)
        memory_.renew(fresh[k], old[k], kept[k], frame.memories[k]);
      else
        Writer(frame.memories[k]).put(kept[k], kMemory);
    }
    const Point pace = frame.motion.step / frame.dt;
    const Point beyond = (frame.motion.step - frame.expected.step) / frame.dt;
    std::vector<float> change = frame.own_row;
    change.resize(kWidth + 6);
    Writer row(change.data() + kWidth);
    row.put(asinh(beyond * 3.0f));
    row.put(elementary::asinh(3.0f * (frame.motion.turn - frame.expected.turn) / frame.dt));
    row.put(pace);
    row.put(frame.motion.turn / frame.dt);
    frame.own_memory = own_memory_(change, {frame.own.memory.begin(), frame.own.memory.end()});
    std::vector<float> thought = frame.own_row;
    thought.insert(thought.end(), frame.own_memory.begin(), frame.own_memory.end());
    thought = hidden(doubt_, thought);
    for (const float uncertain : frame.uncertain) thought.push_back(uncertain * 0.2f);
    thought.push_back(elementary::log(1.0f + frame.known));
    frame.doubt = doubts_(thought, {frame.own.doubt.begin(), frame.own.doubt.end()});
  }

  void answer(const Frame& frame, PoseAnswer& pose, PersonAnswer* places) const {
    const int count = frame.count();
    const auto spread = pose_spread_(frame.doubt);
    pose = {
        frame.motion.step, frame.motion.turn, frame.rough.step, frame.rough.turn, {spread[0], spread[1], spread[2]}};
    Rows facts(count, kWidth + kDoubt + 4);
    for (int k = 0; k < count; ++k) {
      const Person& p = frame.people[k];
      Writer row(facts[k]);
      row.put(frame.thoughts[k], kWidth);
      row.put(frame.doubt.data(), kDoubt);
      row.put(std::array{elementary::log(p.box_along + 1e-3f), elementary::log(p.box_across + 1e-3f), p.sight.placed,
                         elementary::log(std::sqrt(squared(p.place) + 1e-4f))});
    }
    const Rows spreads = place_spread_(facts);
    for (int k = 0; k < count; ++k) places[k] = {frame.people[k].place, {spreads[k][0], spreads[k][1]}};
  }

  /// The state for the next frame, relative to the new pose.
  static void state_after(Frame& frame) {
    const Point back = direction(-frame.motion.turn);
    for (int k = 0; k < frame.count(); ++k) {
      const Person& p = frame.people[k];
      const Sight& s = p.sight;
      const Walker before = frame.remembered[k];
      Walker& after = frame.remembered[k] = p.walker;
      after.place = p.place;
      after.place_before = (before.place - frame.motion.step) * back;
      after.velocity = p.walker.velocity * back;
      for (Point& trace : after.traces) trace = trace * back;
      std::copy_n(frame.memories[k], kMemory, after.memory.begin());
      after.seen = clip(before.seen + s.seen, 0.0f, kLongest);
      after.away = (before.away + frame.dt) * (1.0f - s.seen);
      after.shown = s.seen;
      after.traceable = before.seen > 0.5f ? 1.0f : 0.0f;
      after.exact = s.placed * s.seen;
      after.exact_before = before.exact;
      after.by_height = s.by_height;
      after.by_feet = s.by_feet;
      after.has_feet = s.has_feet;
    }
    Observer& after = frame.own_after;
    const float frames = after.frames;
    after = frame.own;
    after.step = frame.motion.step / frame.dt * back;
    after.turn = frame.motion.turn / frame.dt;
    after.velocity = frame.own.velocity * back;
    after.smooth = frame.own.smooth * back;
    for (Point& trace : after.traces) trace = trace * back;
    std::copy(frame.own_memory.begin(), frame.own_memory.end(), after.memory.begin());
    std::copy(frame.doubt.begin(), frame.doubt.end(), after.doubt.begin());
    after.moved = frames > 0.5f ? 1.0f : 0.0f;
    after.told = frame.given.moved;
    after.frames = clip(frames + 1.0f, 0.0f, kLongest);
  }

  bool pure_, heads_;
  Perceptron walk_, own_walk_, person_, observer_, place_spread_;
  std::vector<Block> blocks_;
  Normalisation after_;
  Linear trust_, own_trust_, look_again_, together_, trust_again_, doubt_, pose_spread_;
  Memory memory_, own_memory_, doubts_;
};

}  // namespace vbbench::former
