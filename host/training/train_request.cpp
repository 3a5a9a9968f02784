// SPDX-License-Identifier: Apache-2.0
#include "host/training/train_request.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <set>

#include "host/support/errors.h"

namespace tactel::host {
namespace {

constexpr int default_epochs = 1000;

/// What the library calls by a name of its own, as the user wrote it.
[[noreturn]] void blame_option(const ValueError& error) {
  const std::string key = error.key.substr(error.key.find('.') + 1);  // "training.rate"
  std::string flag = "--" + key;
  each(train_options, [&](const auto& option) {
    if (option.key() == key) flag = option.flag();
  });
  throw ConfigError("command line", flag, error.value, error.allowed);
}

nn::InputHistory history_of(const TrainRequest& request) {
  nn::InputHistory history = parse_history(request.history, request.history_change);
  history.rest = nn::parse_scaling(request.scaling) == nn::ScalingKind::rest;
  history.frames += history.rest;
  history.friction = request.friction;
  return history;
}

/// The value of an option that was given; empty where it was not.
std::string given(bool value) { return value ? "given" : ""; }
std::string given(const std::string& value) { return value; }
std::string given(const auto& value) { return value ? fmt::format("{}", *value) : ""; }

/// Refuses options that were given and would not be used.
void refuse(const TrainRequest& request, auto member, const std::string& allowed, auto... more) {
  if (const std::string value = given(request.*member); !value.empty())
    throw ConfigError("command line", flag_of(train_options, member), value, allowed);
  (refuse(request, more, allowed), ...);
}

void refuse_beside_stream(const TrainRequest& request) {
  using T = TrainRequest;
  const std::string beside = " with --stream and --block";
  if (!request.stream.empty()) refuse(request, &T::block, "left out with --stream");
  if (request.schedule == "online") refuse(request, &T::schedule, "batch, cosine, or left out," + beside);
  refuse(request, &T::cycles, "left out" + beside + ": --rows sets the end");
  refuse(request, &T::stop_error, "left out" + beside + ": a stream has no cycles");
  if (request.noises.size() > 1) throw ConfigError("command line", "--noise", "several levels", "one level" + beside);
}

void refuse_beside_markers(const TrainRequest& request) {
  using T = TrainRequest;
  const std::string beside = " with --inputs markers";
  if (request.inputs != "markers") throw ValueError("inputs", request.inputs, "stresses or markers");
  if (request.scaling != "set") refuse(request, &T::scaling, "set, or left out," + beside);
  if (request.features != "frame") refuse(request, &T::features, "frame, or left out," + beside);
  refuse(request, &T::bound, "left out" + beside + ": it goes by the tactels that touch");
  refuse(request, &T::alarm_at, "left out" + beside + ": an alarm goes by stresses");
}

void refuse_unused(const TrainRequest& request) {
  using T = TrainRequest;
  if (request.inputs != "stresses") refuse_beside_markers(request);
  if (request.streams())
    refuse_beside_stream(request);
  else
    refuse(request, &T::rows, "left out, or with --stream or --block");
  if ((request.bound || request.magnitude) && request.target != "slip_index")
    refuse(request, &T::target, "slip_index with --bound and --magnitude");
  if (!nn::is_slide(nn::parse_target(request.target)))
    refuse(request, &T::alarm_at, std::string("left out, or with --target ") + nn::slide_names);
  else
    refuse(request, &T::friction, "left out with --target " + request.target + ", which does not depend on mu");
  if (request.stream.empty()) refuse(request, &T::rung, "left out, or with --stream");
  if (!request.bound) refuse(request, &T::level, "left out, or with --bound");
  if (!request.batches()) {
    refuse(request, &T::bound, "left out, or with --schedule batch");
    if (request.activation != "logistic")
      refuse(request, &T::activation, "logistic, left out, or with --schedule batch");
    refuse(request, &T::optimizer, "left out, or with --schedule batch or cosine", &T::batch, &T::loss, &T::average,
           &T::validation_set);
  } else if (request.optimizer.empty() || request.optimizer == "adam") {
    refuse(request, &T::momentum, "left out, or with --optimizer delta or --schedule online");
  }
  if (!request.cosine()) refuse(request, &T::warm_up, "left out, or with --schedule cosine");
  if (request.bound) refuse(request, &T::loss, "left out with --bound: quantiles have the pinball loss");
  if (request.validation_set.empty()) refuse(request, &T::patience, "left out, or with --validation");
}

nn::BatchOptions batch_options(const TrainRequest& request) {
  nn::BatchOptions batch;
  if (!request.optimizer.empty()) batch.rule = nn::parse_rule(request.optimizer);
  if (request.batch) batch.batch = *request.batch;
  batch.cosine = request.cosine();
  const double adam = batch.cosine ? 2e-3 : 1e-3;
  batch.rate = request.rate.value_or(batch.rule == nn::BatchRule::adam ? adam : 0.1);
  batch.warm_up = request.warm_up.value_or(batch.warm_up);
  batch.average = request.average.value_or(batch.average);
  if (!request.loss.empty()) batch.loss = nn::parse_loss(request.loss);
  if (request.momentum) batch.momentum = *request.momentum;
  batch.level = request.level.value_or(batch.level);
  batch.order = nn::parse_order(request.order);
  return batch;
}

/// A name has the inputs of the frames without the rest and what is told. The paper's numbers stand for its hidden
/// layers behind as many as there are.
nn::Topology topology_of(const std::string& name, const nn::InputHistory& history) {
  const nn::Topology topology = nn::Topology::parse(name);
  const bool numbered = name.substr(0, name.find('_')).find('-') == std::string::npos;
  return topology.with_inputs(
      nn::numbers_of(history, numbered ? topology.inputs() : topology.inputs() / history.path()));
}

std::vector<nn::Topology> topologies_of(const TrainRequest& request, const nn::InputHistory& history) {
  std::vector<std::string> names = request.networks;
  if (names.empty()) names = {"1", "2", "3", "4", "5", "6"};
  std::vector<nn::Topology> topologies;
  for (const std::string& name : names) {
    topologies.push_back(topology_of(name, history));
    if (!request.activation.empty())
      topologies.back() = topologies.back().with_activation(nn::parse_activation(request.activation));
    if (request.bound) topologies.back() = topologies.back().with_bound();
    if (std::ranges::count(topologies, topologies.back()) > 1) throw ValueError("network", name, "named once");
  }
  return topologies;
}

/// The name of a plan's topology as the user gives it: without the inputs of the rest and what is told.
std::string named(const nn::Topology& topology, const nn::InputHistory& history) {
  return topology.with_inputs((topology.inputs() - (history.friction ? 2 : 0)) / history.frames * history.path())
      .text();
}

}  // namespace

nn::InputHistory parse_history(const std::string& text, std::optional<double> change) {
  nn::InputHistory history;
  if (!text.empty()) {
    const char* at = text.data();
    const char* const end = at + text.size();
    std::from_chars_result read = std::from_chars(at, end, history.frames);
    if (read.ec == std::errc{} && read.ptr != end && *read.ptr == ':')
      read = std::from_chars(read.ptr + 1, end, history.stride);
    if (read.ec != std::errc{} || read.ptr != end || !history.valid())
      throw ConfigError("command line", "--history", text,
                        "frames, or frames:stride: whole numbers, at most 128 frames and a stride of at most 1000");
  }
  if (!change) return history;
  history.change = *change;
  if (history.frames == 1 || !history.valid())
    throw ConfigError("command line", "--history-change", fmt::format("{}", history.change),
                      "a share of the largest stress, 0 to 1, with --history of 2 frames or more");
  return history;
}

NamedSet read_set(const std::string& file, nn::Target target, bool markers) {
  NamedSet set{file, read_contact_set(file, unread(markers)), {}};
  set.rows = answered_rows(set.contacts, file, target, markers);
  return set;
}

NamedSet read_learning_set(const TrainRequest& request) try {
  NamedSet set = read_set(request.set, nn::parse_target(request.target), request.markers());
  check_learnable(set.rows, request.set);
  set.rows.frames = shown_rows(set.rows.frames, history_of(request), request.learns_magnitude(), request.set);
  set.rows.frames.validate();
  nn::fit_scaling(nn::parse_scaling(request.scaling), set.rows.frames, nn::parse_features(request.features));
  return set;
} catch (const ValueError& error) {
  throw ConfigError(request.set, error);
}

TrainingPlan plan_of(const TrainRequest& request) try {
  refuse_unused(request);
  TrainingPlan plan;
  plan.history = history_of(request);
  plan.magnitude = request.learns_magnitude();
  plan.features = nn::parse_features(request.features);
  plan.target = nn::parse_target(request.target);
  plan.markers = request.markers();
  plan.alarm_at = static_cast<float>(request.alarm_at.value_or(0));
  plan.topologies = topologies_of(request, plan.history);
  if (request.seeds > 1'000'000) throw ValueError("seeds", std::to_string(request.seeds), "at most a million");
  for (std::uint64_t i = 0; i < request.seeds; ++i) plan.seeds.push_back(request.first_seed + i);
  if (!request.noises.empty()) plan.noises = request.noises;
  if (std::set<double>(plan.noises.begin(), plan.noises.end()).size() < plan.noises.size())
    throw ValueError("noise", fmt::format("{}", fmt::join(plan.noises, ", ")), "levels that differ");
  plan.scaling = nn::parse_scaling(request.scaling);
  if (request.streams()) plan.rows = request.rows.value_or(default_rows);
  plan.options.stop_error = request.stop_error.value_or(plan.options.stop_error);
  plan.options.cycle_limit = request.cycles.value_or(request.batches() ? default_epochs : 0);
  plan.options.order = nn::parse_order(request.order);
  if (request.patience.value_or(1) < 1) throw ValueError("patience", std::to_string(*request.patience), "at least 1");
  plan.patience = request.patience.value_or(0);
  if (request.batches()) {
    plan.batch = batch_options(request);
  } else {
    plan.options.rate = request.rate.value_or(plan.options.rate);
    plan.options.momentum = request.momentum.value_or(plan.options.momentum);
  }
  plan.validate();
  return plan;
} catch (const ValueError& error) {
  blame_option(error);
}

void check_width(const TrainingPlan& plan, const NamedSet& set) {
  if (plan.history.path() > 1 && !set.contacts.press_rows)
    throw ConfigError(set.file, "press_rows", "absent",
                      "rows of the pressing, for --history: [sweep] press_rows = true gives them");
  check_width(plan, frame_inputs(set.contacts, plan.markers), set.file);
}

void check_width(const TrainingPlan& plan, int inputs, const std::string& file) {
  const int frames = plan.history.path();
  for (const nn::Topology& topology : plan.topologies)
    if (topology.inputs() != nn::numbers_of(plan.history, inputs))
      throw ConfigError("command line", "--network", named(topology, plan.history),
                        frames == 1 ? fmt::format("a network with {} inputs, as many as {} has", inputs, file)
                                    : fmt::format("a network with {} inputs, {} for each of {} frames", inputs * frames,
                                                  inputs, frames));
}

}  // namespace tactel::host
