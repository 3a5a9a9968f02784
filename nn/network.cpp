// SPDX-License-Identifier: Apache-2.0
#include "nn/network.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "fem/numbers/value_error.h"

namespace tactel::nn {
namespace {

constexpr std::array<std::string_view, 7> target_names{"slip_index", "force_ratio", "stick_fraction", "slid",
                                                       "slip_path",  "net_slip",    "slid_ahead"};  // [Target]

std::size_t place_among(const std::vector<float>& edges, float value) noexcept {
  return static_cast<std::size_t>(std::ranges::count_if(edges, [value](float edge) { return value > edge; }));
}

bool all_finite(const std::vector<float>& numbers) {
  return std::ranges::all_of(numbers, [](float x) { return std::isfinite(x); });
}

void check_edges(const char* key, const std::vector<float>& edges) {
  const bool good = !edges.empty() && edges.size() <= Bound::most_edges &&
                    std::ranges::is_sorted(edges, std::less_equal{}) && all_finite(edges);
  if (!good)
    throw ValueError(std::string("bound.") + key, std::to_string(edges.size()) + " edges",
                     "1 to 16 finite edges, ascending");
}

}  // namespace

const char* name(ScalingKind kind) {
  return kind == ScalingKind::set ? "set" : kind == ScalingKind::frame ? "frame" : "rest";
}

ScalingKind parse_scaling(std::string_view text) {
  for (const ScalingKind kind : {ScalingKind::set, ScalingKind::frame, ScalingKind::rest})
    if (text == name(kind)) return kind;
  throw ValueError("scaling", std::string(text),
                   "set (by the learning set's largest stress), frame (by each frame's own) or rest (by the force of "
                   "the grip at rest)");
}

const char* name(Features features) {
  return features == Features::frame ? "frame" : features == Features::line ? "line" : "pad";
}

Features parse_features(std::string_view text) {
  for (const Features features : {Features::frame, Features::line, Features::pad})
    if (text == name(features)) return features;
  throw ValueError("features", std::string(text), "frame, line or pad");
}

const char* name(Target target) { return target_names[static_cast<std::size_t>(target)].data(); }

Target parse_target(std::string_view text) {
  const auto found = std::ranges::find(target_names, text);
  if (found != target_names.end()) return static_cast<Target>(found - target_names.begin());
  throw ValueError("target", std::string(text), std::string("slip_index, force_ratio, stick_fraction, ") + slide_names);
}

const char* definition(Target target) {
  switch (target) {
    case Target::slid:
      return "D / (1 + D), D: slide of the contact as a whole since rest over its elastic limit";
    case Target::slip_path:
      return "D / (1 + D), D: rms slips of its cells since rest, summed, over its elastic limit";
    case Target::net_slip:
      return "D / (1 + D), D: length of its cells' mean slips since rest, summed, over its elastic limit";
    case Target::slid_ahead:
      return "D / (1 + D), D: slide of the contact as a whole in the next 0.2 s over its elastic limit";
    default:
      return "";
  }
}

void InputScaling::validate() const {
  if (!(largest_stress >= smallest_stress && largest_stress <= large_stress))
    throw ValueError("scaling.largest_stress", std::to_string(largest_stress), "1e-12 to 8.5e37 MPa");
  if (shown() < 1)
    throw ValueError("scaling.history", std::to_string(history),
                     kind == ScalingKind::rest ? "at least 2 frames, the newest and the rest" : "at least 1 frame");
  if (axes < 1 || axes > 3) throw ValueError("scaling.axes", std::to_string(axes), "1, 2 or 3 stresses of a tactel");
  if (features == Features::frame) return;
  if (kind == ScalingKind::set)
    throw ValueError("scaling", name(kind), std::string("frame or rest with the features ") + name(features));
  if (axes != (features == Features::pad ? 3 : 2))
    throw ValueError("features", name(features), "line for tactels with two stresses, pad for those with three");
  if (columns < 1) throw ValueError("scaling.columns", std::to_string(columns), "at least 1 tactel along x");
  if (!(usual_stress >= smallest_stress && usual_stress <= large_stress))
    throw ValueError("scaling.usual_stress", std::to_string(usual_stress), "1e-12 to 8.5e37 MPa");
}

std::size_t Bound::class_of(int touching_tactels, const Quantiles<float>& q, float squared_distance) const noexcept {
  const std::size_t t = place_among(touching, static_cast<float>(touching_tactels));
  const std::size_t s = place_among(slip_index, q.median), w = place_among(width, q.upper - q.lower);
  const std::size_t d = place_among(distance, squared_distance);
  return ((t * (slip_index.size() + 1) + s) * (width.size() + 1) + w) * (distance.size() + 1) + d;
}

BoundAnswer Bound::answer(int touching_tactels, const Quantiles<float>& q, float squared_distance) const noexcept {
  BoundAnswer answer;
  answer.unlike = !(squared_distance <= unlike_above);  // also where it overflows
  if (std::isnan(q.median)) {
    answer.upper = answer.interval[0] = answer.interval[1] = q.median;
    return answer;
  }
  const std::size_t which = class_of(touching_tactels, q, squared_distance);
  const float widening = interval_correction[which];
  // At most 1, where everything slides, and never on the wrong side of S.
  const auto above = [&q](float end) { return std::min(std::max(end, q.median), 1.0f); };
  answer.upper = above(q.upper + upper_correction[which]);
  answer.interval[0] = std::max(std::min(q.lower - widening, q.median), -1.0f);
  answer.interval[1] = above(q.upper + widening);
  return answer;
}

void Bound::validate(int inputs) const {
  check_edges("touching", touching);
  check_edges("slip_index", slip_index);
  check_edges("width", width);
  if (!distance.empty()) check_edges("distance", distance);
  for (const auto& [key, table] : {std::pair{"bound.upper_correction", &upper_correction},
                                   std::pair{"bound.interval_correction", &interval_correction}})
    if (table->size() != classes() || !all_finite(*table))
      throw ValueError(key, std::to_string(table->size()) + " numbers",
                       std::to_string(classes()) + " finite numbers, one for each class");
  const auto count = static_cast<std::size_t>(inputs);
  if (centre.size() != count || whitening.size() != count * count || !all_finite(centre) || !all_finite(whitening))
    throw ValueError("bound.whitening", std::to_string(whitening.size()) + " numbers",
                     "finite, as many rows and columns as the network has inputs");
  if (tactels < 1 || inputs < tactels)
    throw ValueError("bound.tactels", std::to_string(tactels), "1 to the inputs of the network");
  if (!(unlike_above > 0) || !std::isfinite(unlike_above))
    throw ValueError("bound.unlike_above", std::to_string(unlike_above), "finite and above 0");
  if (!(level > 0.5 && level < 1)) throw ValueError("bound.level", std::to_string(level), "above 0.5 and below 1");
}

}  // namespace tactel::nn
