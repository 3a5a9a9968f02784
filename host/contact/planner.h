#pragma once
#include <array>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "host/scenes/ladder.h"

namespace tactel::host {

/// Classes of scenes by the number of touching gap elements: up to 2, 4, 8, 16, and more.
inline constexpr std::array most_touching = {2, 4, 8, 16};
using ByTouching = std::array<double, most_touching.size() + 1>;
std::size_t touching_class(int nodes);
/// Returns the largest number of touching gap elements over the steps.
int touching_nodes(const fem::ContactSolution& solution);

/// Measurements of `tactel tradeoff` on a named rung and its mix of scenes; host/contact/measured_ladder.cpp
/// holds them.
struct MeasuredRung {
  const char* name;
  double steps_per_second;  ///< requested load increments, on the machine of the measurement
  double median, most95;    ///< of the error in S
  double factor;            ///< error in S over the difference in S from its finer_rung: 90 % of the scenes have less
  ByTouching least;         ///< median error in S by touching_class: two rungs may agree by chance, but not so often
};
std::span<const MeasuredRung> measured_ladder();

/// Returns the rung that rung `low` is compared with: the next with a finer contact mesh.
std::size_t finer_rung(std::size_t low);

/// Returns the expected error in S of a rung that differs from the next by `difference`.
double expected_error(const MeasuredRung& rung, double difference, int touching);

/// A rung that was tried, its difference from the next, and its expected error. Of several scenes, the 95 %
/// quantiles.
struct PlanTrial {
  std::string rung, next;
  double difference = 0, estimate = 0;  ///< in S; a contact that either mesh misses, although the load presses, counts
                                        ///< as a difference of 1: nothing is known of its S
  double sigma = 0, tau = 0;            ///< differences of the stresses at the tactels, as AnswerError; no promise
  double P = 0, Q = 0;                  ///< differences of the forces, as AnswerError; no promise
  bool missed = false;                  ///< this is why the difference is 1
};

/// The rung for an accuracy, and the reason. The accuracy holds for S alone; the trials contain the differences
/// of stresses.
struct Plan {
  double accuracy = 0;  ///< requested largest error in S
  Rung rung;
  std::string model{};  ///< description of the rung on the scenes' sensor
  double estimate = 0;  ///< expected error in S; infinite without a finer rung for comparison
  bool kept = false;    ///< estimate <= accuracy; the finest rung that the sensors carry is taken where none keeps it
  std::vector<PlanTrial> trials{};
  std::vector<fem::ContactSolution> answers{};  ///< of the scenes on that rung
  std::string why() const;                      ///< one line
};
nlohmann::ordered_json to_json(const Plan& plan);

/// Answers of scenes on a rung.
using SolveRung = std::function<std::vector<fem::ContactSolution>(const Rung&)>;

/// Returns the cheapest rung that is expected to keep `accuracy` in S on these scenes (in 95 % of them). Tries
/// rungs from the cheapest on, each beside its finer_rung.
Plan plan(std::span<const fem::Scene> scenes, double accuracy, const SolveRung& solve);

}  // namespace tactel::host
