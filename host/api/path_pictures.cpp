// SPDX-License-Identifier: Apache-2.0
#include <tactel/pad.h>

#include <nlohmann/json.hpp>

#include "host/answers/answer_forms.h"
#include "host/answers/convergence.h"
#include "host/api/conversion.h"
#include "host/api/states.h"
#include "host/figures/contact_figure.h"
#include "host/figures/contact_view.h"
#include "host/figures/vtu.h"
#include "host/support/durable_file.h"
#include "host/support/errors.h"
#include "host/support/json_text.h"

namespace tactel {
namespace {

/// The answer of a path that solve() returned.
template <class AnyPath>
const auto& answer_of(const AnyPath& path) {
  using Kind = std::conditional_t<std::is_same_v<AnyPath, Path>, host::SolveOutcome, host::PadOutcome>;
  if (path.outcome.state() == nullptr) throw ValueError("path", "one without its scene", "an answer of solve()");
  return std::get<Kind>(*path.outcome.state()->of);
}

std::size_t checked(std::optional<std::size_t> step, const auto& outcome, std::size_t usual) {
  const std::size_t steps = outcome.solution.steps.size();
  if (step && *step >= steps)
    throw ValueError("step", std::to_string(*step), "a load step from 0 to " + std::to_string(steps - 1));
  return step.value_or(usual);
}

std::string page_of(const auto& path, std::optional<std::size_t> step) {
  return api::with_public_errors([&] {
    const auto& outcome = answer_of(path);
    return host::answer_page(outcome, checked(step, outcome, host::telling_step(outcome.solution))).html();
  });
}

std::string json_of(const auto& path) {
  return api::with_public_errors([&] { return host::json_text(host::to_json(answer_of(path))); });
}

Convergence convergence_of(const auto& path, std::optional<std::size_t> step) {
  return api::with_public_errors([&] {
    const auto& outcome = answer_of(path);
    const host::Convergence found =
        host::converge(outcome, checked(step, outcome, host::telling_step(outcome.solution)));
    Convergence given{.step = found.step};
    for (const auto& rung : found.rungs) given.h.push_back(rung.h);
    for (const auto& number : found.quantities)
      given.numbers.push_back({number.name, number.unit, number.answer, number.fit.limit, number.fit.uncertainty,
                               number.fit.order, number.values});
    return given;
  });
}

void write(const std::string& file, const std::string& text) {
  api::with_public_errors([&] { host::write_file("file", file, text); }, file);
}

}  // namespace

Outcome::~Outcome() { delete state_; }
Outcome::Outcome(const Outcome& other) : state_(other.state_ ? new State(*other.state_) : nullptr) {}
Outcome& Outcome::operator=(const Outcome& other) {
  Outcome copy(other);
  std::swap(state_, copy.state_);
  return *this;
}

std::string html(const Path& path, std::optional<std::size_t> step) { return page_of(path, step); }
std::string html(const PadPath& path, std::optional<std::size_t> step) { return page_of(path, step); }
std::string json(const Path& path) { return json_of(path); }
std::string json(const PadPath& path) { return json_of(path); }
Convergence converge(const Path& path, std::optional<std::size_t> step) { return convergence_of(path, step); }
Convergence converge(const PadPath& path, std::optional<std::size_t> step) { return convergence_of(path, step); }
void to_html(const Path& path, const std::string& file, std::optional<std::size_t> step) {
  write(file, html(path, step));
}
void to_html(const PadPath& path, const std::string& file, std::optional<std::size_t> step) {
  write(file, html(path, step));
}

void to_vtu(const Path& path, const std::string& file, std::optional<std::size_t> step) {
  write(file, api::with_public_errors([&] {
          const auto& outcome = answer_of(path);
          if (outcome.on_patch())
            throw ValueError("path", "an answer on a patch, which has no nodes in the block",
                             "on a mesh, such as that of the rung mesh-161");
          const auto& steps = outcome.solution.steps;
          return host::to_vtu(fem::stress_field(outcome.scene.sensor, steps[checked(step, outcome, steps.size() - 1)]));
        }));
}
void to_vtu(const PadPath& path, const std::string& file, std::optional<std::size_t> step) {
  write(file, api::with_public_errors([&] {
          const auto& outcome = answer_of(path);
          const std::size_t last = outcome.solution.steps.size() - 1;
          return host::field_of(file, outcome.scene, outcome.solution, checked(step, outcome, last));
        }));
}

}  // namespace tactel
