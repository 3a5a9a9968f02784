#pragma once
#include <array>
#include <functional>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "host/ladder.h"

namespace tactel::host {

/// Scenes apart by how many gap elements touch: up to 2, 4, 8, 16, and more.
inline constexpr std::array most_touching = {2, 4, 8, 16};
using ByTouching = std::array<double, most_touching.size() + 1>;
std::size_t touching_class(int nodes);
/// Gap elements that touch in the step in which most do.
int touching_nodes(const fem::ContactSolution& solution);

/// What `tactel tradeoff` found about a named rung on its mix of scenes; host/measured_ladder.cpp holds it.
struct MeasuredRung {
  const char* name;
  double steps_per_second;  ///< load increments asked for, on the machine that measured
  double median, most95;    ///< of the error in S
  double factor;            ///< error in S over the difference in S from its finer_rung: 90 % of the scenes have less
  ByTouching least;         ///< median error in S by touching_class: two rungs may agree by chance, but not so often
};
std::span<const MeasuredRung> measured_ladder();

/// The rung that tells how good rung `low` is: the next with a finer contact mesh.
std::size_t finer_rung(std::size_t low);

/// Error in S to expect of a rung where the next one differs from it by `difference`.
double expected_error(const MeasuredRung& rung, double difference, int touching);

/// A rung that was tried: how far it is from the next, and the error to expect.
struct PlanTrial {
  std::string rung, next;
  double difference = 0, estimate = 0;  ///< in S; of several scenes, the 95 % quantile
};

/// Which rung an accuracy takes, and why.
struct Plan {
  double accuracy = 0;  ///< largest error in S that is asked for
  Rung rung;
  double estimate = 0;  ///< error in S to expect of it
  bool kept = false;    ///< estimate <= accuracy; the finest rung is taken where none keeps it
  std::vector<PlanTrial> trials{};
  std::vector<fem::ContactSolution> answers{};  ///< of the scenes on that rung
  std::string why() const;                      ///< one line
};
nlohmann::ordered_json to_json(const Plan& plan);

/// Answers of scenes on a rung.
using SolveRung = std::function<std::vector<fem::ContactSolution>(const Rung&)>;

/// The cheapest rung that is expected to keep `accuracy` in S on these scenes (in 95 % of them): tries rungs from the
/// cheapest on, each beside its finer_rung.
Plan plan(std::span<const fem::Scene> scenes, double accuracy, const SolveRung& solve);

}  // namespace tactel::host
