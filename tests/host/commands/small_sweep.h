// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

namespace tactel::host {

/// A sweep file of contacts that are quickly solved: 11 columns, 4 rows, 5 tactels.
struct SmallSweep {
  int contacts = 9000;           ///< two chunks
  std::string sweep{};           ///< more lines of [sweep]
  std::string friction = "0.5";  ///< mu
  std::string indenter = "[indenter]\nshape = \"parabola\"\nradius = 10\n";
  std::string indentation = "{ uniform = [0.1, 0.2] }";
  std::string drag = "tangential = [0.05]";
  int tactels = 5;

  std::string text() const {
    return "[sweep]\ncontacts = " + std::to_string(contacts) + "\n" + sweep +
           "[sensor]\ncolumns = 11\nrows = 4\ntactels = " + std::to_string(tactels) +
           "\n[contact]\nfriction = " + friction + "\n" + indenter + "[load]\nindentation = " + indentation + "\n" +
           drag + "\n";
  }
};

}  // namespace tactel::host
