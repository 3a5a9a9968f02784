// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace tactel {

/// The rows of a set (docs/sets.md), one a load step, and where they are from. Forces are those of the indenter on the
/// rubber.
struct SetArrays {
  std::vector<float> frames;                          ///< [rows, inputs] MPa: normal stresses first, then shear
  std::vector<float> markers;                         ///< [rows, markers, 3] mm, of pads: displacements; or empty
  std::vector<float> pixels;                          ///< [rows, markers, 2] where a camera sees them; or empty
  std::vector<float> slip_index;                      ///< [rows] S = Q / (mu P); of pads 1 / lambda
  std::vector<float> normal_force, tangential_force;  ///< [rows] P, Q, N/mm; of pads [rows], [rows, 2] N
  std::vector<float> indentation, tangential;         ///< [rows] mm: depth and way along x since first touch; or empty;
                                                      ///< of pads the position [rows, 2]
  std::vector<float> torque, twist, force_ratio;      ///< [rows] of pads: M, N mm; degrees; |Q| / (mu P)
  std::vector<float> slid;                      ///< [rows] of pads: slide as a whole since first touch over its limit
  std::vector<float> slip_path;                 ///< [rows] of pads: the cells' rms slips, summed, over that limit
  std::vector<float> net_slip, net_turn;        ///< [rows, 2], [rows] of grips with a rate: mean slips, added up
  std::vector<float> slid_ahead;                ///< [rows] of grips with a rate: growth of slid in the next 0.2 s
  std::vector<float> friction, stick_fraction;  ///< [rows] mu; stuck share of the contact's length, or cells
  std::vector<float> residual;                  ///< [rows] largest relative residual
  std::vector<std::uint64_t> contact;           ///< [rows] contact of the sweep
  std::vector<std::uint32_t> step;              ///< [rows] load step of the contact, from 0
  std::vector<std::uint16_t> indenter;          ///< [rows] index in indenter_names
  std::vector<std::uint16_t> contact_nodes;     ///< [rows] surface nodes, or cells, that touch
  std::vector<std::uint8_t> status;             ///< [rows] 0 solved, 1 sliding, 2 over tolerance, 3 few cells touch
  std::vector<std::uint8_t> outside;            ///< [rows] of pads, what the model does not serve: sum of
                                                ///< 1 nearer than the thickness H to an edge, 2 farther than H
                                                ///< from every tactel at a pitch above 2 H, 4 cells longer than H
  std::vector<float> poisson, thickness, young, length;  ///< [rows] of the contact's own sensor, mm and MPa; or empty
  std::vector<float> parameters;                         ///< [contacts, names] what was drawn; NaN: has none; or empty
  std::vector<std::string> indenter_names;               ///< attribute, and so are the next
  std::uint64_t contacts = 0;                            ///< that were simulated
  std::string sweep, rung, device;                       ///< text of the sweep file; model; OpenCL device
  std::string transducer;                                ///< measuring chain of the stresses
  std::string plan;  ///< conditions of the rows beside the sweep; empty where they are not those of the whole file
  std::uint64_t seed = 0;
  bool press_rows = false;  ///< the load steps of the pressing are rows, too: networks with history need them

  std::size_t rows() const { return slip_index.size(); }
};

}  // namespace tactel
