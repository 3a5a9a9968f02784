// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "host/answers/rung_error.h"
#include "host/scenes/ladder.h"

namespace tactel::host {

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
  double difference = 0;      ///< in S; a contact that either misses, although the load presses, counts as 1
  double estimate = 0;        ///< expected error in S of `rung`
  double next_estimate = 0;   ///< expected error in S of `next`
  double sigma = 0, tau = 0;  ///< differences of the stresses at the tactels, as AnswerError; no promise
  double P = 0, Q = 0;        ///< differences of the forces, as AnswerError; no promise
  bool missed = false;        ///< a contact is missed
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
  std::string model{};  ///< description of the rung
  double estimate = 0;  ///< error in S to expect of it
  bool kept = false;    ///< estimate <= accuracy; the reference is taken where no rung below it keeps the accuracy
  std::vector<PlanTrial> trials{};
  std::vector<fem::ContactSolution> answers{};  ///< of the scenes on that rung
  std::string why() const;                      ///< one line
  /// Returns the rung, or the finest of the device in place of an exact one, which is too slow for many contacts.
  const Rung& rung_for_many() const;
};
nlohmann::ordered_json to_json(const RungChoice& plan);

/// Answers of scenes on a rung.
using SolveRung = std::function<std::vector<fem::ContactSolution>(const Rung&)>;

/// Returns the cheapest rung that is expected to keep `accuracy` in S on these scenes (in 95 % of them). Climbs the
/// ladder from the cheapest rung on and compares each rung with the next.
RungChoice plan(std::span<const fem::Scene> scenes, double accuracy, const SolveRung& solve);

}  // namespace tactel::host
