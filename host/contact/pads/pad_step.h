// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "fem/pad/creep.h"
#include "fem/pad/pad_surface.h"
#include "host/contact/contact_batch.h"
#include "host/contact/pads/pad_step_grid.h"
#include "host/contact/pads/pad_step_tables.h"

namespace tactel::host {

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

  std::size_t count() const { return count_; }
  std::size_t tactels() const { return stresses_.numbers.rows / 3; }
  const fem::PadCells& cells() const { return cells_; }
  const StepOptions& options() const { return options_; }
  bool of_means() const { return sides_.has_value(); }     ///< what cells do to each other are means, beside free sides
  std::size_t lanes() const { return width_ * vectors_; }  ///< contacts of a work-item
  std::size_t state_rows() const { return head_.size() + state_.rows; }  ///< numbers of a contact in state()

  /// Seconds that each step takes from now on, of rubber that creeps.
  void set_dt(double dt);

  // What the next step takes. All of it stays until it is given anew. Wrong sizes throw ValueError.
  void set_friction(std::span<const double> friction);  ///< [count], one for all, or [count][cells]
  /// [count][cells] mm above the lowest point of the object, +infinity where there is none; cover [count][cells] 0 to
  /// 1, or empty: 1. Numbers that are no heights, and a cover that is none, make a contact STEP_INVALID.
  void set_heights(std::span<const double> heights, std::span<const double> cover = {});
  /// The same of one contact. `beyond`: fem::height_beyond, mm; below 0: not known, as of heights.
  void set_surface(std::size_t contact, const fem::PadSurface& surface, double beyond = -1);
  void set_axes(std::span<const double> axes);  ///< [count][2] mm: the object's axis, of twists and torques

  /// Steps by motion: pose [count][4], depth, x, y (mm), twist (rad), of the whole way since the contact was reset.
  void move(std::span<const double> pose) { step(pose, false); }
  /// Steps by wrench [count][4]: P, Qx, Qy (N), M (N mm); P <= 0: open.
  void press(std::span<const double> wrench) { step(wrench, true); }

  // Answers of the last step, in memory of the device where that is the host's: valid until the next step, at most as
  // long as the stepper.
  std::span<const Real> results() const;  ///< [count][STEP_RESULT_ROWS] of kernels/shared/pad_step_layout.h
  /// [count][3][tactels] MPa: sigma_z, tau_x, tau_y; made at the first call.
  std::span<const Real> frames() { return made(stresses_); }
  /// Displacements of the markers, [count][markers][3] mm; empty without markers.
  std::span<const Real> markers() { return made(displacements_); }
  std::vector<double> poses() const;  ///< [count][4] depth, x, y (mm), twist (rad) where the contacts are
  /// Tractions on the cells, [count][3][cells] MPa: n, t_x, t_y.
  std::vector<double> tractions() const;

  /// Contacts as nothing had touched them. `mask` [count]: not 0 where.
  void reset(std::span<const std::uint8_t> mask);
  void reset() { state_.fill(0); }
  /// Numbers [contacts][state_rows()] of these contacts, or of all: PadStateHead, then the rows of
  /// kernels/shared/pad_step_layout.h. Setting them gives the same bits from then on, in any stepper of this rubber,
  /// cells and precision; where it creeps, both have markers or none. Throws ValueError, and sets nothing, where a head
  /// is of others or a number is not finite.
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
  void set_reach(double reach) { step_launch_.set("reach", static_cast<Real>(std::min(reach, 1e20))); }
  /// Contacts that cover this share of the grid are split; above 1: none, for tests.
  void set_wide_share(double share);

 private:
  using Mapping = typename Buffer<Real>::Mapping;
  /// Numbers of each contact that are sums over its tractions: made where they are asked for.
  struct Sums {
    Buffer<Real> base{};
    LaneArray<Real> numbers{};
    Launch launch{};
    std::unique_ptr<Mapping> view{};  ///< none: not made since the last step
  };
  /// Of rubber that creeps.
  struct Creeping {
    fem::Creep law;
    Buffer<Real> numbers;  ///< of the step: how much softer, and its terms
  };

  const Device& device() const { return executor_->device(); }
  std::size_t cell_count() const { return static_cast<std::size_t>(cells_.count()); }
  void check_count(std::size_t state_rows) const;
  void make_tables(const PairInfluence& pairs);
  void make_launches();
  void take_map();
  void check_state(std::span<const Real> numbers) const;
  void put_input(std::size_t first, std::span<const double> from, std::span<const double> units);
  void put_heights(std::size_t contact, const double* height, const double* cover, std::span<Real> all,
                   std::span<Real> softs) const;
  double put_creep();
  void step(std::span<const double> to, bool by_wrench);
  void forget();
  std::span<const Real> made(Sums& sums);

  Executor* executor_;
  fem::PadSensor pad_;
  StepOptions options_;
  std::size_t count_, width_, vectors_, places_;  ///< places: contacts with those that fill up a work-item
  fem::PadCells cells_;
  fem::SoftObject object_{};
  std::optional<fem::PadSides> sides_{};  ///< free ones
  double root_zz_ = 0, root_tt_ = 0, rho_n_ = 1, rho_t_ = 1, kt_ = 0, kr_ = 0;
  int wide_from_ = 0;    ///< cells in the window of a contact that is split
  bool mapped_ = false;  ///< each cell has its own mu
  bool marked_ = false;  ///< markers in rubber that creeps, whose states have more rows
  bool dense_ = false;   ///< the table is of all pairs of cells
  bool writes_ = false;  ///< the driver's kernel does, as the first step has shown
  Buffer<Real> table_, blocks_;
  LaneArray<Real> input_, heights_, soft_, state_, result_;
  std::vector<Real> head_;  ///< PadStateHead
  Launch step_launch_;
  Sums stresses_{}, displacements_{};
  std::optional<Creeping> creep_{};
  mutable std::unique_ptr<Mapping> result_view_{};
};

extern template class PadStepper<float>;
extern template class PadStepper<double>;

}  // namespace tactel::host
