// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <compare>
#include <memory>
#include <span>
#include <vector>

#include "fem/pad/pad_solver.h"
#include "host/contact/stream_of.h"
#include "host/scenes/hold_load.h"
#include "host/sets/held_contact.h"
#include "kernels/shared/pad_layout.h"

namespace tactel::host {

/// A grip that holds an object, [load.hold]: its load is the hold's.
struct HeldScene : fem::PadScene {
  Hold hold;
};

/// How grips are stepped.
struct HeldModel {
  std::vector<fem::PadSensor> sensors;  ///< of all scenes
  int cells = 0;                        ///< along the pad's shorter side
  double accept = 0;                    ///< as GapSweepOptions; 0: the usual
  Precision precision = Precision::fp32;
  std::optional<Markers> markers{};
};

/// What scenes of one launch have in common: a launch is by wrench or by motion of all contacts.
struct HeldKey {
  std::size_t sensor = 0;  ///< of the model's
  int pressing = 0;        ///< frames
  auto operator<=>(const HeldKey&) const = default;
};

/// Rows of a frame's result: PadResultRow, and these. PAD_RESULT_SLID and PAD_RESULT_SLIP_PATH are over the elastic
/// limit.
enum HeldResultRow {
  HELD_X = PAD_RESULT_ROWS,  ///< mm, and the next; rad
  HELD_Y,
  HELD_TWIST,
  HELD_STICK,  ///< share of the touching cells that stick; RESULT_SLIPPING has all of them
  HELD_NET_X,  ///< HeldContact::net_slip, and the next two
  HELD_NET_Y,
  HELD_NET_TURN,
  HELD_SLID_AHEAD,  ///< how far it slides as a whole in the next 0.2 s, over the elastic limit; NaN: it ends before
  HELD_OUTSIDE,     ///< sum of PadOutside
  HELD_RESULT_ROWS
};

/// Grips, for a stream: contacts with one sensor that press in as many frames are stepped together
/// (host/contact/pads/pad_step.h), a frame a step. The answer of a grip depends on its scene alone. None is solved
/// again.
class HeldContacts {
 public:
  using Scene = HeldScene;
  using Sensor = fem::PadSensor;
  struct Path {
    std::span<const Hold::Frame> steps;
  };
  using Solution = fem::PadSolution;
  using Model = HeldModel;
  using Key = HeldKey;

  HeldContacts(Executor& executor, HeldModel model) : executor_(executor), model_(std::move(model)) {}
  Key key(const Sensor& sensor, ContactKind) const;
  Key key(const Scene& scene) const { return {key(scene.sensor, {}).sensor, scene.hold.pressing()}; }
  static Path path(const Scene& scene) { return {scene.hold.frames}; }
  std::shared_ptr<const SensorSolver<HeldContacts>> solver(const Sensor& sensor) const;
  static void finish(std::span<const Scene>, std::vector<Solution>&) {}
  static std::vector<std::size_t> coarse(const Scene&, const LaneAnswer&) { return {}; }
  static Scene alone(const Scene& scene, std::size_t) { return scene; }

 private:
  Executor& executor_;
  HeldModel model_;
};

static_assert(Contacts<HeldContacts>);

}  // namespace tactel::host
