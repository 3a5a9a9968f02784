// SPDX-License-Identifier: Apache-2.0
#include "host/networks/training_plan.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "fem/numbers/value_error.h"
#include "host/support/checksum.h"

namespace tactel::host {
namespace {

// The cycle that a learning curve keeps after this one.
std::uint64_t next_point(std::uint64_t cycle) { return cycle < 10 ? cycle + 1 : cycle + cycle / 10; }

std::uint64_t checksum_of(const float* data, Eigen::Index count) {
  return checksum({reinterpret_cast<const char*>(data), static_cast<std::size_t>(count) * sizeof(float)});
}

}  // namespace

const CurvePoint& point_at(const std::vector<CurvePoint>& curve, std::uint64_t CurvePoint::*place, std::uint64_t at) {
  const auto after = std::ranges::upper_bound(curve, at, {}, place);
  return after == curve.begin() ? curve.front() : *(after - 1);
}

void TrainedNetwork::note_cycle(const nn::CycleErrors& errors, std::uint32_t its_rows, bool last) {
  ++cycles, rows += its_rows;
  sse = static_cast<float>(errors.sse), largest = static_cast<float>(errors.largest);
  if (last || cycles >= next_point(curve.empty() ? 0 : curve.back().cycle))
    curve.push_back({cycles, rows, sse, static_cast<float>(errors.sse / its_rows), largest});
}

void TrainedNetwork::stop_early(std::uint32_t its_rows) {
  status = nn::TrainStatus::early_stop;
  if (curve.back().cycle != cycles) curve.push_back({cycles, rows, sse, sse / static_cast<float>(its_rows), largest});
}

void TrainingPlan::validate() const {
  if (topologies.empty()) throw ValueError("network", "none", "at least one network");
  if (seeds.empty()) throw ValueError("seeds", "none", "at least one seed");
  if (noises.empty()) throw ValueError("noise", "none", "at least one level, 0 for none");
  for (const double noise : noises)
    if (!(noise >= 0 && noise <= 1))
      throw ValueError("noise", std::to_string(noise), "a fraction of the largest stress, 0 to 1: 0.1 for 10 %");
  for (const nn::Topology& topology : topologies) {
    if (batch) break;
    if (topology.has_bound())
      throw ValueError("network", topology.text(), "one output, or --schedule batch for the heads of a bound");
    if (topology.hidden_activation() != nn::Activation::logistic)
      throw ValueError("network", topology.text(), "logistic neurons, or --schedule batch");
  }
  if (features != nn::Features::frame && scaling == nn::ScalingKind::set)
    throw ValueError("scaling", nn::name(scaling), std::string("frame with --features ") + nn::name(features));
  options.validate();
  if (batch) batch->validate();
  if (validation && !batch) throw ValueError("validation", "given", "left out, or with --schedule batch or cosine");
}

std::string set_description(const nn::FrameSet& set) {
  return fmt::format("set {} {}", set.rows(),
                     checksum_of(set.frames.data(), set.frames.size()) ^
                         (checksum_of(set.slip_index.data(), set.slip_index.size()) << 1));
}

std::string training_description(const std::string& source, int lanes, Precision precision, const TrainingPlan& plan) {
  std::string text = fmt::format("{} lanes {} scaling {} networks", name(precision), lanes, nn::name(plan.scaling));
  for (const nn::Topology& topology : plan.topologies) text += ' ' + topology.text();
  if (plan.features != nn::Features::frame) text += fmt::format(" features {}", nn::name(plan.features));
  text += fmt::format(" seeds {} noises {:a}", fmt::join(plan.seeds, " "), fmt::join(plan.noises, " "));
  if (plan.rows)
    text += fmt::format(" rows {}", *plan.rows);
  else
    text += fmt::format(" stop {:a} limit {}", plan.options.stop_error, plan.options.cycle_limit);
  if (plan.batch) {
    const nn::BatchOptions& batch = *plan.batch;
    text += fmt::format(" batch {} {} {:a} {:a} {:a} {:a} {:a} {}", nn::name(batch.rule), batch.batch, batch.rate,
                        batch.momentum, batch.beta1, batch.beta2, batch.epsilon, nn::name(batch.order));
    if (std::ranges::any_of(plan.topologies, &nn::Topology::has_bound)) text += fmt::format(" level {:a}", batch.level);
    if (batch.loss != nn::Loss::squared) text += fmt::format(" {}", nn::name(batch.loss));
    if (batch.cosine) text += fmt::format(" cosine {:a}", batch.warm_up);
    if (batch.average > 0) text += fmt::format(" average {:a}", batch.average);
    if (plan.validation)
      text += fmt::format(" validation {} patience {}", set_description(*plan.validation), plan.patience);
  } else {
    text += fmt::format(" rate {:a} momentum {:a} {}", plan.options.rate, plan.options.momentum,
                        nn::name(plan.options.order));
  }
  return text + "\n" + source;
}

}  // namespace tactel::host
