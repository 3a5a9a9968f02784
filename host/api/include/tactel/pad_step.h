// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/pad.h>
#include <tactel/step_options.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

// Contacts inside a simulator or a control loop (docs/stepping.md): each call takes thousands of contacts with one pad
// an increment on, by the motion or the wrench that is known only then. Lengths in mm, forces in N, torques in N mm,
// angles in degrees. Wrenches are those of the object on the rubber, in the axes of the pad (docs/frames.md).

namespace tactel {

/// What a step says, but for the frames. Twist and torque are about the object's axis.
struct StepAnswer {
  std::vector<float> force;           ///< [count, 4]: P, Qx, Qy of the object on the rubber, M
  std::vector<float> pose;            ///< [count, 4]: depth, x, y, twist since the contact was reset
  std::vector<float> slip_index;      ///< [count] S; 0 where mu P = 0
  std::vector<float> stick_fraction;  ///< [count] cells that stick over those that touch
  std::vector<std::uint32_t> flags;   ///< [count] sums of StepFlag
  std::vector<float> residual;        ///< [count] largest residual of the laws, relative
  std::vector<std::uint32_t> solves;  ///< [count] poses that were solved
  std::vector<std::uint32_t> sweeps;  ///< [count]
};

/// `count` contacts with one pad. Objects are shapes with places, or gaps that the caller computes. Every function
/// throws InputError for arrays of a wrong size, HardwareError where the device fails. A step that a CancelScope ends
/// leaves all contacts as they were. Not for several threads at once.
class TACTEL_API PadStepper {
 public:
  /// `friction` as of set_friction. options() then has the grid.
  PadStepper(const Pad& pad, std::size_t count, std::span<const double> friction, const StepOptions& options = {});
  ~PadStepper();
  PadStepper(PadStepper&&) noexcept;
  PadStepper& operator=(PadStepper&&) noexcept;

  std::size_t count() const;
  std::size_t tactels() const;
  std::vector<double> cell_x() const, cell_y() const;  ///< [cells] mm on the pad, y fastest
  std::string device() const;
  const StepOptions& options() const;

  void set_dt(double dt);  ///< seconds that each step takes from now on, of a pad that relaxes
  /// [count], one for all, or [count, cells]; from the next step on.
  void set_friction(std::span<const double> friction);
  /// One object for all contacts, or one for each, at its position and yaw.
  void set_shapes(std::span<const PadIndenter> indenters);
  /// Places of the objects [count, 3]: x, y, yaw, on the pad. Friction does not feel that: it sees motion alone.
  void set_places(std::span<const double> places);
  /// Instead of shapes: gaps [count, cells] from rubber at rest to the object, < 0 where they overlap, +infinity where
  /// there is none; cover [count, cells] of a cell 0 to 1, empty: 1. Twists and torques are then about the pad's
  /// middle.
  void set_gaps(std::span<const float> gaps, std::span<const float> cover = {});

  /// Steps by motion: pose [count, 4] depth, x, y, twist since the contact was reset. Shapes travel with x, y and twist
  /// where `travel` says so.
  const StepAnswer& move(std::span<const double> pose, bool travel = true);
  /// Steps to the gaps, with the motion along the pad since the last step, [count, 3] x, y, twist.
  const StepAnswer& move_by(std::span<const double> motion);
  /// Steps by wrench [count, 4]: P, Qx, Qy, M; finds the pose. P <= 0: open. Contacts where the mask [count] is 0 stay
  /// as they are, with their last answers; empty: all step.
  const StepAnswer& press(std::span<const double> wrench, std::span<const std::uint8_t> mask = {});

  const StepAnswer& answer() const;  ///< of the last step
  /// Frames of the last step, [count, 3, tactels] MPa: sigma_z, tau_x, tau_y, tactels with x fastest. In fp32 on a
  /// processor they are the device's own memory. Valid until the next step.
  std::span<const float> frames();
  /// Displacements of the markers after the last step, [count, markers, 3] mm along x, y, z; empty without markers.
  /// Valid as frames().
  std::span<const float> markers();
  std::vector<float> pixels();            ///< [count, markers, 2] where the camera sees them; empty without a camera
  std::vector<double> tractions() const;  ///< [count, 3, cells] MPa: n, t_x, t_y

  void reset();                                    ///< as if nothing had touched: all contacts
  void reset(std::span<const std::uint8_t> mask);  ///< those where the mask [count] is not 0
  std::size_t state_size() const;                  ///< numbers of the state of a contact
  /// The state of these contacts, or of all: [contacts, state_size()]. From a state that is set, steps have the bits
  /// that they had from where it was taken: in any stepper of this rubber, cells and precision. Each begins with these:
  /// throws InputError, and sets nothing, where they are others, or a number is not finite.
  std::vector<double> state(std::span<const std::size_t> contacts = {}) const;
  void set_state(std::span<const double> state, std::span<const std::size_t> contacts = {});

  struct State;

 private:
  State* state_;
};

}  // namespace tactel
