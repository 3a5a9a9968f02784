// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/pad.h>
#include <tactel/progress.h>
#include <tactel/scene.h>
#include <tactel/set_arrays.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace tactel {

/// Frames with their answers, as in a set file.
struct Set : SetArrays {
  std::size_t inputs = 0;                    ///< axes of every tactel
  std::size_t axes = 2;                      ///< stresses of a tactel; of a pad 3, or 1
  std::vector<float> tactel_x, tactel_y;     ///< [tactels] mm; empty where contacts differ in them; tactel_y: of pads
  std::vector<std::string> parameter_names;  ///< keys, such as "indenter.radius"
  std::vector<std::string> parameter_units;  ///< [names]
  std::uint64_t fell_back = 0, unsolved = 0, without_rows = 0;
};

/// Reads a set file (HDF5). Throws InputError for one that cannot be read or is damaged.
TACTEL_API Set read_set(const std::string& path);
/// Writes a set file, for `tactel train`, h5py and others: that of `tactel generate` for the rows of a whole sweep
/// file. Arrays that are empty are left out. Throws InputError where it cannot be written.
TACTEL_API void write_set(const Set& set, const std::string& path);

/// How a sweep is simulated.
struct SweepOptions {
  std::optional<double> accuracy{};   ///< largest error in S, in 95 % of the contacts: the planner chooses the rung
  std::string rung{};                 ///< empty: as the file says
  std::string precision{};            ///< "fp32", "fp64"; empty: the rung's, or fp32
  std::string device{};               ///< name or index of an OpenCL device; empty: the default device
  std::optional<double> tolerance{};  ///< of the sweeps; none: the rung's
  bool transducer = true;             ///< with the sweep's [transducer]
};

/// Numbers that take the place of the sensor's in a sweep file.
struct SensorChange {
  std::optional<int> tactels{};
  std::optional<double> thickness{};  ///< mm
};

/// The contacts of a sweep file: contact k is a function of the file, its seed and k alone.
class TACTEL_API Sweep {
 public:
  /// Reads a sweep file (TOML). `seed` takes the place of the file's. Throws InputError as read_scene.
  explicit Sweep(const std::string& path, std::optional<std::uint64_t> seed = {}, const SensorChange& sensor = {});
  ~Sweep();
  Sweep(Sweep&&) noexcept;
  Sweep& operator=(Sweep&&) noexcept;

  std::string text() const;        ///< of the file
  std::uint64_t contacts() const;  ///< as the file says
  bool endless() const;            ///< whether contacts beyond contacts() exist: drawn ones, not listed ones
  std::uint64_t seed() const;
  std::size_t tactels() const;
  std::size_t axes() const;  ///< stresses of a tactel: 2 of lines; of pads 3, or 1
  bool pads() const { return axes() != 2; }
  std::vector<std::string> indenter_names() const;
  std::vector<std::string> warnings() const;  ///< of numbers that look as if they had another unit; usually none
  /// Returns contact k < contacts(), or any k where endless().
  Scene scene(std::uint64_t k) const;
  /// The same of a sweep of pads. Both throw InputError for a sweep of the other kind.
  PadScene pad_scene(std::uint64_t k) const;

  /// Returns, of each number that a contact draws, whether it grows steadily with its quantile: choices do not. A
  /// contact needs only the numbers of the tables that it draws.
  std::vector<bool> numbers() const;
  /// Returns the sweep of the contacts with these quantiles, [contacts][numbers()] in [0, 1), instead of drawn ones: a
  /// contact as a function of uniform numbers, for samplers. Throws InputError for others, and for a listed sweep.
  Sweep of_quantiles(std::span<const double> quantiles) const;

  /// Returns the rows of contacts 0 ... contacts - 1 (none given: all of the file), the same as those of
  /// `tactel generate`. Throws InputError, HardwareError, and Cancelled where progress (contacts) says so.
  Set generate(std::optional<std::uint64_t> contacts = {}, const SweepOptions& options = {},
               const ProgressFunction& progress = {}) const;

  struct State;

 private:
  explicit Sweep(State* state) : state_(state) {}
  friend class SweepBatches;
  State* state_;
};

/// Rows of a sweep batch after batch, never stored: contacts 0 ... contacts - 1, then the next ones.
class TACTEL_API SweepBatches {
 public:
  /// `contacts` a batch. `first`: the contact to begin with. The sweep may end before the batches do.
  SweepBatches(const Sweep& sweep, std::uint64_t contacts, const SweepOptions& options = {}, std::uint64_t first = 0);
  ~SweepBatches();
  SweepBatches(SweepBatches&&) noexcept;
  SweepBatches& operator=(SweepBatches&&) noexcept;

  /// Simulates the next batch into `rows`. Returns false at the end of the contacts: never where the sweep is endless.
  bool next(Set& rows);

  struct State;

 private:
  State* state_;
};

}  // namespace tactel
