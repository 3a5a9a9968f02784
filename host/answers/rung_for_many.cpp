// SPDX-License-Identifier: Apache-2.0
#include "host/answers/rung_for_many.h"

#include <algorithm>

#include "host/contact/lines/sensor_tables.h"
#include "host/contact/lines/solve_on_rung.h"
#include "host/support/chosen_row.h"
#include "host/support/errors.h"

namespace tactel::host {

std::optional<Rung> named_rung_for_many(const SolveOptions& options) {
  check_modelling(options);
  if (options.rung.empty()) return {};
  const Rung& rung = rung_named(options.rung);
  if (rung.exact)
    throw ConfigError("command line", "--rung", options.rung,
                      "a rung for many contacts, such as patch-24 or mesh-641: the reference solves single contacts");
  return rung;
}

std::optional<PadRung> pad_rung_for_many(const SolveOptions& options) {
  check_modelling(options);
  if (options.rung.empty()) return {};
  const PadRung& rung = pad_rung_named(options.rung);
  if (rung.exact)
    throw ConfigError("command line", "--rung", options.rung,
                      "a rung for many scenes, pad-8 to pad-24: the reference solves single ones");
  return rung;
}

RungChoice plan_for_many(Executor& executor, double accuracy, const ManyContacts& contacts) {
  std::vector<fem::Scene> sample;
  const std::uint64_t count = std::min(contacts.count, most_tried);
  for (std::uint64_t k = 0; k < count; ++k) sample.push_back(contacts.contact(chosen_row(k, count, contacts.count)));
  std::shared_ptr<const fem::SensorFamily> family;
  if (contacts.own_sensors)
    family = std::make_shared<const fem::SensorFamily>(sensor_family(executor, *contacts.own_sensors));
  return plan(sample, accuracy, [&](const Rung& rung) { return solve_on_rung(executor, sample, rung, true, family); });
}

std::optional<Rung> rung_for_many(Executor& executor, const SolveOptions& options, const ManyContacts& contacts) {
  if (auto rung = named_rung_for_many(options)) return rung;
  if (!options.accuracy) return {};
  return plan_for_many(executor, *options.accuracy, contacts).rung_for_many();
}

}  // namespace tactel::host
