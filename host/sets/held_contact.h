// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <span>

#include "fem/pad/pad_cells.h"
#include "host/scenes/scene_source.h"

namespace tactel::host {

/// What a step of a contact said, in the frame of the pad.
struct HeldStep {
  std::array<double, 4> force{};  ///< P, Qx, Qy (N), M (N mm) about the object's axis
  std::array<double, 4> pose{};   ///< depth, x, y (mm), twist (rad)
  double area = 0;                ///< mm^2 of the cells that touch
  double slip = 0;                ///< mm: rms slide in this step of the cells that touch
  std::array<double, 3> mean{};   ///< mm: their mean slide, x, y, and its turn times their rms radius
  bool slides = false;            ///< none of them sticks
};

/// A grip on its way: what its next step asks for, from what the last one said. It is pressed by wrench, then stepped
/// by motion. The hand keeps its force a step behind, by the depth. By force the object moves in each frame by what the
/// pad lacks of its load over a sticking stiffness: it comes to rest where friction bears the load, else it slides. Its
/// face moves with its place, and tilts with the last step's shear force. Where it rolls its face goes on, but drags no
/// rubber.
class HeldContact {
 public:
  HeldContact(const fem::PadScene& scene, const Hold& hold, const fem::PadCells& cells);

  /// Whether frame k is stepped by wrench, not by motion.
  bool by_wrench(std::size_t k) const { return k < pressing_; }
  /// Puts the object over the cells for frame k: heights and cover [cells], its axis; returns the wrench, or the pose,
  /// of the frame.
  std::array<double, 4> ask(std::size_t k, std::span<double> heights, std::span<double> cover,
                            std::array<double, 2>& axis);
  void take(std::size_t k, const HeldStep& step);

  /// How far the contact has slid as a whole, and the sum of its cells' rms slips, over the elastic limit.
  double slid() const { return slid_; }
  double slip_path() const { return slip_path_; }
  /// The sum of its cells' mean slides, x, y and turn, over the elastic limit: ways back and forth cancel.
  const std::array<double, 3>& net_slip() const { return net_slip_; }

 private:
  void put_object(std::size_t k, std::span<double> heights, std::span<double> cover, std::array<double, 2>& axis);
  double depth(std::size_t k) const;
  double shear_stiffness(const HeldStep& step) const;
  std::array<double, 3> moved(std::size_t k) const;
  void learn_stiffness(std::size_t k, const HeldStep& step);
  std::array<double, 4> pose(std::size_t k) const;
  std::array<double, 3> way_by_force(std::size_t k) const;
  double limit(const HeldStep& step) const;
  double force(std::size_t k) const;
  double from_lowest() const { return last_.pose[0] - lowest_; }

  fem::PadSensor sensor_;
  fem::PadIndenter indenter_;
  double friction_, preload_;
  Hold hold_;
  fem::PadCells cells_;
  std::size_t pressing_;             ///< frames
  std::array<double, 3> place_{};    ///< of the object's axis: x, y (mm), turn (rad)
  HeldStep last_, pressed_;          ///< of the last step, and of the last of the pressing
  double lowest_ = 0;                ///< mm: of the object over the cells
  double pressed_depth_ = 0;         ///< mm from there
  double unit_ = 0, arm_ = 0;        ///< mm: elastic limit, at most so far that the way stays within H; arm of the turn
  double way_ = 0;                   ///< mm: of the cells
  double slid_ = 0, slip_path_ = 0;  ///< over the elastic limit
  std::array<double, 3> net_slip_{};
  double stiffness_ = 1, work_ = 0, estimated_ = 0;  ///< along the pad, over its estimate; N mm that it had and should
};

}  // namespace tactel::host
