// SPDX-License-Identifier: Apache-2.0
#include "host/api/modelling.h"

#include "host/contact/planner.h"
#include "host/contact/solve.h"
#include "host/contact/solve_on_rung.h"
#include "host/support/errors.h"

namespace tactel::api {

void check_precision(const std::string& precision) {
  if (!precision.empty() && precision != "fp32" && precision != "fp64")
    throw ConfigError("command line", "--precision", precision, "fp32 or fp64");
}

std::optional<host::Rung> rung_for_many(host::Executor& executor, const std::string& rung,
                                        const std::optional<double>& accuracy, std::span<const fem::Scene> sample) {
  host::SolveOptions modelling;
  modelling.rung = rung, modelling.accuracy = accuracy;
  host::check_modelling(modelling);
  if (!rung.empty()) {
    const host::Rung& named = host::rung_named(rung);
    if (named.exact)
      throw ConfigError("command line", "--rung", rung,
                        "a rung for many contacts, such as patch-24 or mesh-641: the reference solves single contacts");
    return named;
  }
  if (!accuracy) return {};
  const host::Plan chosen = host::plan(
      sample, *accuracy, [&](const host::Rung& tried) { return host::solve_on_rung(executor, sample, tried); });
  return chosen.rung_for_many();
}

}  // namespace tactel::api
