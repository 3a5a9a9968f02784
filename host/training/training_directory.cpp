// SPDX-License-Identifier: Apache-2.0
#include "host/training/training_directory.h"

#include <sys/stat.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "host/support/bounded_file.h"
#include "host/support/durable_file.h"
#include "host/support/errors.h"

namespace tactel::host {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::uintmax_t largest_report = std::uintmax_t{1} << 30;  ///< some 64 kB a network

[[noreturn]] void refuse_directory(const fs::path& path, const std::string& allowed) {
  throw ConfigError("command line", "--output", path.string(), allowed);
}

// Empty where it is missing or damaged.
json read_json(const fs::path& path) {
  json value = json::parse(read_report(path), nullptr, false);
  return value.is_object() ? value : json::object();
}

/// Keeps every other process out of the directory until this one ends.
void lock_until_the_end(const fs::path& path) {
  static std::map<std::pair<dev_t, ino_t>, FileLock> held;
  struct stat status {};
  if (::stat(path.c_str(), &status) == 0 && held.contains({status.st_dev, status.st_ino})) return;
  FileLock lock = FileLock::of_folder("--output", path, "a directory in which no other program is training");
  held.emplace(std::pair{status.st_dev, status.st_ino}, std::move(lock));
}

}  // namespace

std::string read_report(const fs::path& path) try {
  return read_bounded_file(path, largest_report);
} catch (const UnreadableFile& error) {
  if (error.missing) return "";
  throw ConfigError(path.string(), "report", std::string("cannot be read (") + error.what() + ")",
                    "one that tactel train wrote, or absent");
}

bool TrainingDirectory::finished() const { return fs::exists(report()); }

bool TrainingDirectory::interrupted() const { return !checkpoints().empty(); }

std::vector<fs::path> TrainingDirectory::checkpoints() const {
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(path_))
    if (entry.path().filename().string().starts_with("checkpoint")) files.push_back(entry.path());
  return files;
}

std::vector<std::string> TrainingDirectory::own_networks() const {
  std::vector<std::string> files;
  for (const json& network : read_json(report()).value("networks", json::array()))
    if (network.is_object() && network.contains("file") && network["file"].is_string())
      files.push_back(fs::path(network["file"].get<std::string>()).filename());
  return files;
}

void TrainingDirectory::check(bool resume, bool force) const {
  make_folder("--output", path_);
  lock_until_the_end(path_);
  check_writable("--output", report());
  if (resume) return;
  if (!force && finished())
    refuse_directory(path_, "a directory without a finished training, or --force to train anew and overwrite it");
  if (!force && interrupted())
    refuse_directory(
        path_, "a directory without an interrupted training, or --resume to continue it, or --force to train anew");
  const std::vector<std::string> expected = own_networks();
  for (const fs::directory_entry& entry : fs::directory_iterator(path_))
    if (entry.path().extension() == ".onnx" &&
        std::ranges::find(expected, entry.path().filename().string()) == expected.end())
      refuse_directory(path_,
                       "a directory without networks of another origin (" + entry.path().filename().string() + ")");
}

void TrainingDirectory::expect_same(const std::string& fingerprint) const {
  const json its_report = read_json(report());
  if (!its_report.contains("fingerprint") || its_report["fingerprint"] != fingerprint)
    throw ConfigError(report().string(), "fingerprint", "of another training",
                      "of this one (same set, networks, seeds, noise, options, precision and device lanes); or --force "
                      "to train anew, or another --output");
}

void TrainingDirectory::clear() const {
  for (const std::string& file : own_networks()) fs::remove(network(file));
  fs::remove(report());
  fs::remove(figure());
  fs::remove(curves());
  remove_checkpoints();
}

std::string TrainingDirectory::draw(const Figure& curves) const try {
  write_figure("--output", figure(), curves);
  return "";
} catch (const std::exception& error) {
  return error.what();
}

void TrainingDirectory::remove_checkpoints() const {
  for (const fs::path& file : checkpoints()) fs::remove(file);
}

}  // namespace tactel::host
