// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <gtest/gtest.h>

#include <filesystem>

#include "host/scenes/paper_sets.h"
#include "host/sets/contact_set.h"
#include "host/sets/set_simulator.h"
#include "tests/host/networks/network_cases.h"
#include "tests/host/support/run_tactel.h"

namespace tactel::tests {

/// The paper's sets in files, simulated once for a test program.
class PaperSetFiles {
 public:
  static const std::string& learning() { return files().learning_; }
  static const std::string& recall() { return files().recall_; }

 private:
  PaperSetFiles() {
    write(learning_, host::paper_learning_family(host::paper_set_scene(), 10, 10));
    write(recall_, host::paper_recall_family(host::paper_set_scene()));
  }
  static void write(const std::string& path, const host::SceneFamily& family) {
    host::write_contact_set(path, host::simulate_family(executor(), family, host::Precision::fp64, 0));
  }
  static const PaperSetFiles& files() {
    static const PaperSetFiles files;
    return files;
  }
  host::ScratchFolder folder_;
  std::string learning_ = folder_ / "learning.h5", recall_ = folder_ / "recall.h5";
};

/// What each file of a directory holds, by name.
inline std::map<std::string, std::string> networks_in(const std::filesystem::path& directory) {
  std::map<std::string, std::string> all;
  for (const auto& entry : std::filesystem::directory_iterator(directory))
    if (entry.path().extension() == ".onnx") all[entry.path().filename()] = host::text_of(entry.path());
  return all;
}

}  // namespace tactel::tests
