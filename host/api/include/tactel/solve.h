// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/progress.h>
#include <tactel/scene.h>
#include <tactel/solve_options.h>

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tactel {

/// Status of a surface node (mesh) or element (patch).
enum class NodeStatus : std::uint8_t { open, stick, slip };

/// Residual of the contact laws in a step; all relative.
struct Residual {
  double penetration = 0, cone = 0, complementarity = 0, drift = 0, balance = 0;
};

/// The state at the end of a load increment.
struct Step {
  double indentation = 0, tangential = 0;  ///< mm, position of the indenter
  double P = 0, Q = 0;                     ///< N/mm, of the indenter on the rubber; Q > 0 drags it to +x
  double slip_index = 0;                   ///< S = Q / (mu P); NaN where mu P = 0
  double slip_distance = 0;                ///< mm: largest slide of the indenter over the rubber since first touch
  std::vector<NodeStatus> status;          ///< [surface]
  std::vector<double> normal_force, tangential_force;  ///< [surface] N/mm; normal >= 0 presses
  std::vector<double> base_force_x, base_force_y;      ///< [base] N/mm, rubber on base; empty on a patch
  std::vector<double> sigma_y, tau_xy;                 ///< [tactels] MPa; sigma_y < 0 is compression
  bool converged = false;
  int iterations = 0;
  Residual residual;
};

/// Expected error of an answer: S absolutely, the others of their largest.
struct ExpectedError {
  double S = 0, P = 0, Q = 0, sigma_y = 0, tau_xy = 0;
  std::string finer;  ///< the model of comparison, "81 x 21"
};

/// What solve() keeps for pages and fields. Copies share it.
class TACTEL_API Outcome {
 public:
  struct State;
  Outcome() noexcept = default;  ///< none
  explicit Outcome(State* state) noexcept : state_(state) {}
  ~Outcome();
  Outcome(const Outcome&);
  Outcome& operator=(const Outcome&);
  const State* state() const noexcept { return state_; }

 private:
  State* state_ = nullptr;
};

/// The answer to a scene: one Step for each load increment, those of the indentation first.
struct Path {
  std::vector<Step> steps;
  std::vector<double> surface_x, surface_width;  ///< [surface] mm; widths of a patch's elements, empty on a mesh
  std::vector<double> base_x, tactel_x;          ///< [base], [tactels] mm
  bool sliding = false;                          ///< the last step slides as a whole
  bool fell_back = false;                        ///< the exact fallback answered
  std::string model, model_reason;               ///< "patch of 12 elements, 2.9 mm wide", and why
  std::string solver, precision, device;
  std::optional<ExpectedError> error;
  std::vector<std::string> warnings;
  Outcome outcome{};
};

/// Solves one contact. Throws InputError for a scene or options that cannot be used, HardwareError without a device.
TACTEL_API Path solve(const Scene& scene, const SolveOptions& options = {});

/// Returns the page of `tactel solve --html`: the contact over its load steps, with this one first, from 0 (none: the
/// last that sticks and slips). Throws InputError for a path that solve() did not return, or a step that it has not.
TACTEL_API std::string html(const Path& path, std::optional<std::size_t> step = {});
/// Writes that page to a file. Throws InputError also for a file that cannot be written.
TACTEL_API void to_html(const Path& path, const std::string& file, std::optional<std::size_t> step = {});

/// Returns the JSON of `tactel solve --json`. Throws InputError for a path that solve() did not return.
TACTEL_API std::string json(const Path& path);

/// A number of a load step on ever smaller cells, continued to cells of size 0 (docs/accuracy.md).
struct ConvergedNumber {
  std::string name, unit;
  double answer = 0;                  ///< of the path
  double limit = 0, uncertainty = 0;  ///< on cells of size 0
  double order = 0;                   ///< of convergence; 0: the values scatter, and `limit` is the last
  std::vector<double> values{};       ///< [rungs]
};
struct Convergence {
  std::size_t step = 0;                    ///< of the path
  std::vector<double> h{};                 ///< [rungs] mm, size of cells, the largest first
  std::vector<ConvergedNumber> numbers{};  ///< none where fewer than four rungs were solved
};
/// Solves the scene of a path on ever smaller cells, as `tactel solve --converge`, and judges a step (none: the last
/// that sticks and slips). Takes seconds to minutes. Throws InputError as html().
TACTEL_API Convergence converge(const Path& path, std::optional<std::size_t> step = {});

/// Writes the VTK file of `tactel solve --field` of a step (none: the last): displacement and stress in the block. Of
/// an answer on a mesh alone: a patch has no nodes in the block. Throws InputError.
TACTEL_API void to_vtu(const Path& path, const std::string& file, std::optional<std::size_t> step = {});

/// Answers of many scenes as arrays, the last index fastest. Steps are those that the loads ask for, on every rung;
/// `steps` is that of the longest path. Entries beyond a scene's own steps are NaN, and so is S where mu P = 0. Forces
/// are those of the indenter on the rubber.
struct Paths {
  std::size_t scenes = 0, steps = 0, tactels = 0;
  std::vector<std::uint32_t> steps_made;         ///< [scenes]
  std::vector<double> slip_index, P, Q;          ///< [scenes, steps] S, N/mm, N/mm
  std::vector<double> indentation, tangential;   ///< [scenes, steps] mm
  std::vector<double> slip_distance;             ///< [scenes, steps] mm
  std::vector<double> sigma_y, tau_xy;           ///< [scenes, steps, tactels] MPa
  std::vector<std::uint8_t> converged;           ///< [scenes, steps] 1: within its tolerance
  std::vector<std::uint8_t> sliding, fell_back;  ///< [scenes] 1: the last step slides; the exact fallback answered
  std::string rung, precision, device;           ///< rung: empty for scenes on their own meshes
  std::vector<std::string> warnings;             ///< of numbers that look as if they had another unit
};

/// Solves scenes in batches. Without a rung, scenes with a mesh are solved on it and others on patches of 12 elements,
/// in fp32 unless `options.precision` says otherwise. An accuracy is judged on at most 64 of the scenes. Throws
/// InputError, naming the scene by its index, HardwareError, and Cancelled where progress (scenes) says so.
TACTEL_API Paths solve_many(std::span<const Scene> scenes, const SolveOptions& options = {},
                            const ProgressFunction& progress = {});

}  // namespace tactel
