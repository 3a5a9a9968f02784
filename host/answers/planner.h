// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/solve_options.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fem/layer/sensor_family.h"
#include "host/answers/line_error.h"
#include "host/scenes/ladder.h"
#include "host/support/chosen_row.h"

namespace tactel::host {

class Executor;

/// Measurements of `tactel tradeoff` on a rung of the ladder and its mix of scenes; host/answers/measured_ladder.cpp
/// holds them. A difference is that in S from the next rung of the ladder.
struct MeasuredRung {
  const char* name;
  ErrorLine error;       ///< error in S over the difference
  ErrorLine next_error;  ///< the next rung's error over the same difference
  double most;  ///< error in S that 98 % of the scenes stay below, whatever the difference. Of the reference, its
                ///< own error in 95 % of the scenes
};
std::span<const MeasuredRung> measured_ladder();

/// A rung that was tried, its difference from the next, and the expected errors of both. Of several scenes, the 95 %
/// quantiles.
struct PlanTrial {
  std::string rung, next;
  AnswerError difference{};  ///< in S 1 where either misses a contact, although the load presses; others: no promise
  double estimate = 0;       ///< expected error in S of `rung`
  double next_estimate = 0;  ///< expected error in S of `next`
  bool missed = false;       ///< a contact is missed
};

/// Returns the expected errors in S of a rung of the ladder, and of the next, which differ by `difference`: the line,
/// or what 98 % of all scenes stay below where that is less; the difference where that is more. For a scene outside the
/// mix it is three times the line.
double expected_error(std::size_t rung, double difference, bool outside = false);
double expected_next_error(std::size_t rung, double difference, bool outside = false);

inline constexpr double least_friction = 0.1;  ///< of the mix

/// Returns true for scenes that are harder than the mix of the measurements: with less friction, on linear elements
/// (fem/layer/linear_elements.h), or near an end of the rubber.
bool outside_the_mix(const fem::Scene& scene, const fem::ContactSolution& answer);

/// The rung for an accuracy, and the reason. The accuracy holds for S alone; the trials contain the differences
/// of stresses.
struct RungChoice {
  double accuracy = 0;  ///< requested largest error in S
  Rung rung;
  double estimate = 0;  ///< error in S to expect of it
  bool kept = false;    ///< estimate <= accuracy; the reference is taken where no rung below it keeps the accuracy
  std::vector<PlanTrial> trials{};
  std::vector<fem::ContactSolution> answers{};  ///< of the scenes on that rung
  std::string why() const;                      ///< one line
  /// Returns the rung, or the finest of the device in place of an exact one, which is too slow for many contacts.
  const Rung& rung_for_many() const;
};
nlohmann::ordered_json to_json(const RungChoice& plan);

/// Returns what the planner knows of its answer's error; none where a mesh missed a contact or no rung was compared.
std::optional<ExpectedError> mesh_error(const RungChoice& plan);

/// Answers of scenes on a rung.
using SolveRung = std::function<std::vector<fem::ContactSolution>(const Rung&)>;

/// Returns the cheapest rung that is expected to keep `accuracy` in S on these scenes (in 95 % of them). Climbs the
/// ladder from the cheapest rung on and compares each rung with the next.
RungChoice plan(std::span<const fem::Scene> scenes, double accuracy, const SolveRung& solve);

// ---- of many contacts

/// Largest number of contacts that are tried for all of them.
inline constexpr std::uint64_t most_tried = 64;

/// Returns at most so many of `count` contacts, one from each equal part of all; contact(k) is contact k.
template <class Contact>
auto tried_of(std::uint64_t count, const Contact& contact) {
  const std::uint64_t tried = std::min(count, most_tried);
  std::vector<std::decay_t<decltype(contact(count))>> some;
  for (std::uint64_t k = 0; k < tried; ++k) some.push_back(contact(chosen_row(k, tried, count)));
  return some;
}

/// Contacts of which the planner tries some.
struct ManyContacts {
  std::uint64_t count = 0;
  std::function<fem::Scene(std::uint64_t k)> contact;  ///< returns contact k
  std::optional<fem::SensorRange> own_sensors = {};    ///< where each contact has its own sensor, of this range
};

/// Returns the rung of lines or pads that --rung names; none where it names none. Throws ConfigError for contradictory
/// options, and for a rung that solves single contacts.
template <class AnyRung = Rung>
std::optional<AnyRung> named_rung_for_many(const SolveOptions& options);

/// Returns the planner's choice for those that it tries.
RungChoice plan_for_many(Executor& executor, double accuracy, const ManyContacts& contacts);

/// Returns the rung that --rung names, or that --accuracy takes; none without both. Throws as named_rung_for_many.
std::optional<Rung> rung_for_many(Executor& executor, const SolveOptions& options, const ManyContacts& contacts);

}  // namespace tactel::host
