#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "nn/frame_set.h"

namespace tactel::host {

/// A set of contacts as it stands in a set file (interface.md): one row a load step; HDF5, plain datasets.
struct ContactSet {
  int inputs = 0;                 ///< 2 tactels
  std::vector<float> frames;      ///< `/inputs` [rows, inputs] MPa: normal stress of every tactel, then shear
  std::vector<float> slip_index;  ///< [rows] S = Q / (mu P)
  std::vector<float> normal_force, tangential_force;  ///< [rows] P, Q, N/mm
  std::vector<float> friction;                        ///< [rows] mu
  std::vector<float> stick_fraction;                  ///< [rows] stuck length over contact length
  std::vector<std::uint16_t> contact_nodes;           ///< [rows] surface nodes that touch
  std::vector<std::uint64_t> contact;                 ///< [rows] which contact of the sweep
  std::vector<std::uint32_t> step;                    ///< [rows] which load step of it, from 0
  std::vector<std::uint16_t> indenter;                ///< [rows] which kind of indenter: a place in indenter_names
  std::vector<std::uint8_t> status;                   ///< [rows] LaneStatus: 0 solved, 1 sliding, 2 over tolerance
  std::vector<float> residual;                        ///< [rows] largest relative residual

  std::vector<std::string> indenter_names;  ///< attribute
  std::string sweep;                        ///< attribute: text of the sweep file
  std::string device, rung;                 ///< attributes: who simulated, how finely
  std::string transducer;                   ///< attribute: what became of the stresses, nn::description
  std::uint64_t seed = 0;                   ///< attribute
  std::uint64_t fell_back = 0;  ///< attribute: contacts that the sweeps gave up and the exact fallback took over
  std::uint64_t unsolved = 0;   ///< attribute: contacts with a load step over tolerance all the same
  std::uint64_t too_deep = 0;   ///< contacts indented beyond the depth to which rubber is linear; not in the file

  std::size_t rows() const { return slip_index.size(); }
  /// What networks learn from or are judged by.
  nn::FrameSet frames_with_answers() const;
};

/// Calls visit(name, values, columns, unit) for every dataset of a set; columns 0: a plain list.
template <class Set, class Visit>
void each_dataset(Set& set, const Visit& visit) {
  visit("inputs", set.frames, set.inputs, "MPa; normal stress of every tactel, then shear");
  visit("slip_index", set.slip_index, 0, "1; Q / (mu P)");
  visit("normal_force", set.normal_force, 0, "N/mm");
  visit("tangential_force", set.tangential_force, 0, "N/mm");
  visit("friction", set.friction, 0, "1");
  visit("stick_fraction", set.stick_fraction, 0, "1; stuck length over contact length");
  visit("contact_nodes", set.contact_nodes, 0, "surface nodes that touch");
  visit("contact", set.contact, 0, "which contact");
  visit("step", set.step, 0, "which load step of the contact");
  visit("indenter", set.indenter, 0, "place in the attribute indenter_names");
  visit("status", set.status, 0, "0 solved, 1 sliding, 2 over tolerance");
  visit("residual", set.residual, 0, "1; largest relative residual");
}

/// Writes a set file piece by piece, under a temporary name until finish(). Throws ConfigError naming --output where it
/// cannot be written, and leaves nothing behind then.
class ContactSetWriter {
 public:
  /// `rows`: of all pieces.
  ContactSetWriter(const std::filesystem::path& path, int inputs, std::size_t rows);
  ~ContactSetWriter();
  ContactSetWriter(const ContactSetWriter&) = delete;
  ContactSetWriter& operator=(const ContactSetWriter&) = delete;
  void append(const ContactSet& rows);
  /// Writes the attributes of `set` (its rows are not looked at) and gives the file its name.
  void finish(const ContactSet& set);

 private:
  [[noreturn]] void fail() const;
  struct State;
  std::unique_ptr<State> state_;
};

/// A whole set at once.
void write_contact_set(const std::filesystem::path& path, const ContactSet& set);

/// Reads parts of a set file. Throws ConfigError as read_contact_set.
class ContactSetReader {
 public:
  explicit ContactSetReader(const std::filesystem::path& path);
  ~ContactSetReader();
  std::uint64_t rows() const;
  int inputs() const;
  /// Rows first ... first + count - 1, which must be there; no attributes but indenter_names.
  ContactSet read(std::uint64_t first, std::uint64_t count) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Throws ConfigError where the file cannot be read, is no set, or holds datasets of the wrong shape.
ContactSet read_contact_set(const std::filesystem::path& path);
/// The text of the sweep file that a set was made from. Throws as read_contact_set.
std::string contact_set_sweep(const std::filesystem::path& path);

}  // namespace tactel::host
