// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/step_options.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "fem/pad/pad_surface.h"
#include "host/device/executor.h"

namespace tactel::host {

/// What cells fixed to a pad do to each other where that depends on their places:
/// [place][source] [displacement x, y, z][force x, y, z] mm by a traction of 1 at E = 1. Empty: of the pad's own
/// rubber, with its sides where they are free.
using PairInfluence = std::vector<double>;

/// What the state of a contact begins with: lengths over H. With a soft object its softness and Poisson's ratio follow,
/// and with layers (0, 0 where there is no soft object) those of fem::Rubber, three numbers each. Rubber that creeps
/// has these two, too, and behind all state_relaxation and its pairs.
enum PadStateHead {
  state_cells_x,
  state_cells_y,
  state_hx,
  state_hy,
  state_poisson,
  state_length,  ///< of free sides; 0: held
  state_width,
  state_head
};
inline constexpr double state_relaxation = -1;

/// Many contacts with one pad that take one increment a call, each on from the state that the last left in the device's
/// buffers: launcher of kernels/pad_step.cl. Its twin is fem::SteppedContact. Move only.
template <class Real>
class PadStepper {
 public:
  /// `friction` as of set_friction. Throws ValueError for a pad, a number or an option that is not served.
  PadStepper(Executor& executor, const fem::PadSensor& pad, std::size_t count, std::span<const double> friction,
             const StepOptions& options = {}, const PairInfluence& pairs = {});
  ~PadStepper();
  PadStepper(PadStepper&&) noexcept;
  PadStepper& operator=(PadStepper&&) noexcept;

  std::size_t count() const;
  std::size_t tactels() const;
  const fem::PadCells& cells() const;
  const StepOptions& options() const;
  std::size_t lanes() const;       ///< contacts of a work-item
  std::size_t state_rows() const;  ///< numbers of a contact in state()

  /// Seconds that each step takes from now on, of rubber that creeps.
  void set_dt(double dt);

  // What the next step takes. All of it stays until it is given anew. Wrong sizes throw ValueError.
  void set_friction(std::span<const double> friction);  ///< [count], one for all, or [count][cells]
  /// [count][cells] mm above the lowest point of the object, +infinity where there is none; cover [count][cells] 0 to
  /// 1, or empty: 1. Numbers that are no heights, and a cover that is none, make a contact STEP_INVALID.
  template <class Number>
  void set_heights(std::span<const Number> heights, std::span<const Number> cover = {});
  /// The same of one contact. `beyond`: fem::height_beyond, mm; below 0: not known, as of heights.
  void set_surface(std::size_t contact, const fem::PadSurface& surface, double beyond = -1);
  void set_axes(std::span<const double> axes);  ///< [count][2] mm: the object's axis, of twists and torques

  /// Steps by motion: pose [count][4], depth, x, y (mm), twist (rad), of the whole way since the contact was reset.
  void move(std::span<const double> pose);
  /// Steps by wrench [count][4]: P, Qx, Qy (N), M (N mm); P <= 0: open.
  void press(std::span<const double> wrench);

  // Answers of the last step, in memory of the device where that is the host's: valid until the next step, at most as
  // long as the stepper.
  std::span<const Real> results() const;  ///< [count][STEP_RESULT_ROWS] of kernels/shared/pad_step_layout.h
  std::span<const Real> frames();         ///< [count][3][tactels] MPa: sigma_z, tau_x, tau_y; made at the first call
  /// Displacements of the markers, [count][markers][3] mm; empty without markers.
  std::span<const Real> markers();
  std::vector<double> poses() const;  ///< [count][4] depth, x, y (mm), twist (rad) where the contacts are
  /// Tractions on the cells, [count][3][cells] MPa: n, t_x, t_y.
  std::vector<double> tractions() const;

  /// Contacts as nothing had touched them. `mask` [count]: not 0 where.
  void reset(std::span<const std::uint8_t> mask);
  void reset();
  /// Numbers [contacts][state_rows()] of these contacts, or of all: PadStateHead, then the rows of
  /// kernels/shared/pad_step_layout.h. Setting them gives the same bits from then on, in any stepper of this rubber,
  /// cells and precision. Throws ValueError, and sets nothing, where a head is of others or a number is not finite.
  std::vector<Real> state(std::span<const std::size_t> contacts = {}) const;
  void set_state(std::span<const Real> numbers, std::span<const std::size_t> contacts = {});

  /// States and results of all contacts, in the device's order.
  struct Kept {
    std::vector<Real> state, result;
  };
  Kept keep() const;
  /// Puts them back: of all contacts, or of those where `mask` [count] is 0.
  void put_back(const Kept& kept, std::span<const std::uint8_t> mask = {});

  /// Cells are near up to this part of the depth above it; infinity: all, for tests.
  void set_reach(double reach);
  /// Contacts that cover this share of the grid are split; above 1: none, for tests.
  void set_wide_share(double share);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

extern template class PadStepper<float>;
extern template class PadStepper<double>;

}  // namespace tactel::host
