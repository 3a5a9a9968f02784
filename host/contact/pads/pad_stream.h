// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <compare>
#include <memory>
#include <span>
#include <tuple>
#include <variant>
#include <vector>

#include "fem/pad/pad_presses.h"
#include "host/contact/pads/pad_contact.h"
#include "host/contact/stream_of.h"
#include "host/scenes/ladder.h"

namespace tactel::host {

/// How contacts on pads are solved.
struct PadModel {
  fem::PadOptions options{};
  Precision precision = Precision::fp32;
};
PadModel model_of(const PadRung& rung);

/// What scenes of one launch have in common: the tactels, and free_block; where their markers lie, over the thickness;
/// whether they have maps of friction, and the terms of their creep.
struct PadKey {
  std::pair<PadTactels, std::array<double, 4>> sensor{};
  std::pair<double, std::vector<std::array<double, 2>>> markers{};
  bool mapped = false;
  std::size_t creep_terms = 0;
  auto operator<=>(const PadKey&) const = default;
};

/// Contacts on pads, for a stream.
class PadContacts {
 public:
  using Scene = fem::PadScene;
  using Sensor = fem::PadSensor;
  using Path = PadPath;
  using Solution = fem::PadSolution;
  using Model = PadModel;
  using Key = PadKey;

  PadContacts(Executor& executor, const PadModel& model);
  static Key key(const Sensor& sensor, ContactKind);
  static Key key(const Scene& scene);
  static Path path(const Scene& scene) {
    fem::require_times(scene);
    return {fem::pad_targets(scene.load)};
  }
  std::shared_ptr<const SensorSolver<PadContacts>> solver(const Sensor& sensor) const;
  static void finish(std::span<const Scene>, std::vector<Solution>&) {}
  /// Coarse steps of the pressing (fem/pad/pad_presses.h).
  std::vector<std::size_t> coarse(const Scene& scene, const LaneAnswer& answer) const;
  static Scene alone(const Scene& scene, std::size_t step) { return fem::pressed_alone(scene, step); }

 private:
  std::variant<PadContact<float>, PadContact<double>> contact_;
};

static_assert(Contacts<PadContacts>);

/// The stream of contacts on pads.
using PadStream = StreamOf<PadContacts>;
extern template class StreamOf<PadContacts>;

/// Returns true where every step of a solution has converged.
bool every_step_converged(const fem::PadSolution& solution);

/// Solves scenes in their order; `cells` as PadContact::prepare. Where the surface is penetrated beyond the cells, they
/// grow, and the scene is solved again. Without `cells`, coarse steps of the pressing are solved alone
/// (fem/pad/pad_presses.h). A scene with a step over tolerance
/// after that is solved by the twin in fp64, to a sweep tolerance of 1e-6 or the kernel's, if that is finer, if need be
/// on 24 x 24 cells, and has fell_back = true. Steps that still miss their tolerance have converged = false.
template <class Real>
std::vector<fem::PadSolution> solve_pad_contact(const PadContact<Real>& contact, std::span<const fem::PadScene> scenes,
                                                std::span<const fem::PadCells> cells = {});

}  // namespace tactel::host
