// Binding of the learned network: people, boxes and answers come as arrays of float32, laid out as its structs.
#include <cstring>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "binding.hpp"
#include "former/network.hpp"

using namespace vbbench;

namespace {

/// The network, whose weights are checked as it is made.
struct Network {
  former::Network network;

  Network(const nb::dict& weights, bool heads) : network(made(weights, heads)) {}

  static former::Network made(const nb::dict& weights, bool heads) {
    std::map<std::string, former::Weight> found;
    for (const auto& [key, value] : weights) {
      const std::string name = nb::str(key).c_str();
      Array<const float> values;
      if (!nb::try_cast(nb::borrow(value), values, false))
        refuse("the weights '" + name + "' must be an array of float32 in C order");
      former::Weight& weight = found[name];
      for (std::size_t i = 0; i < values.ndim(); ++i) weight.shape.push_back(values.shape(i));
      weight.values.assign(values.data(), values.data() + values.size());
    }
    try {
      return {former::Weights(std::move(found)), heads};
    } catch (const std::invalid_argument& error) {
      refuse(error.what());
    }
  }

  void advance(const nb::object& people, const nb::object& observer, const nb::object& sights, const nb::object& given,
               float dt, float spread, const nb::object& pose, const nb::object& places) const {
    using namespace former;
    const auto rows = array<float>(people, "people", {kAny, static_cast<std::size_t>(kWalkerFloats)});
    const std::size_t count = rows.shape(0);
    const auto own = array<float>(observer, "observer", {kObserverFloats});
    const auto boxes = array<const float>(sights, "sights", {count, kSightFloats});
    const auto frame = array<const float>(given, "given", {kGivenFloats});
    const auto out_pose = array<float>(pose, "pose", {kPoseAnswerFloats});
    const auto out_places = array<float>(places, "places", {count, kPersonAnswerFloats});
    std::vector<Walker> walkers(count);
    std::vector<Sight> seen(count);
    std::vector<PersonAnswer> answers(count);
    former::Observer self;
    Given facts;
    PoseAnswer answer;
    read(rows, walkers.data(), count);
    read(boxes, seen.data(), count);
    read(own, &self, 1);
    read(frame, &facts, 1);
    network.advance(walkers.data(), self, static_cast<int>(count), seen.data(), facts, dt, spread, answer,
                    answers.data());
    write(walkers.data(), count, rows);
    write(&self, 1, own);
    write(&answer, 1, out_pose);
    write(answers.data(), count, out_places);
  }

  template <class T>
  static void read(const auto& from, T* to, std::size_t count) {
    if (count) std::memcpy(static_cast<void*>(to), from.data(), count * sizeof(T));
  }
  template <class T>
  static void write(const T* from, std::size_t count, const auto& to) {
    if (count) std::memcpy(to.data(), from, count * sizeof(T));
  }
};

}  // namespace

namespace vbbench {

void bind_former(nb::module_& module) {
  nb::class_<Network>(module, "FormerNetwork", "The learned network with its weights.")
      .def(nb::init<const nb::dict&, bool>(), nb::arg("weights"), nb::arg("heads"))
      .def("advance", &Network::advance, array_arg("people"), array_arg("observer"), array_arg("sights"),
           array_arg("given"), nb::arg("dt"), nb::arg("spread"), array_arg("pose"), array_arg("places"),
           "Takes a frame, renews what is remembered of people and observer, and writes the last two arrays.");
}

}  // namespace vbbench
