// SPDX-License-Identifier: Apache-2.0
#include "fem/numbers/cache_directory.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>

namespace tactel::fem {
namespace {

namespace fs = std::filesystem;

/// A group of the user's own number is the user's alone: many systems give each user one, and a umask of 002.
bool others_can_write(const struct stat& status) {
  return (status.st_mode & S_IWOTH) != 0 || ((status.st_mode & S_IWGRP) != 0 && status.st_gid != ::geteuid());
}

std::string others_text(const fs::path& folder, const char* first = "") {
  return "others can write to " + folder.string() + ": " + first + "chmod go-w " + folder.string();
}

/// As distrust, for the folders that lead to it, by the names given. Where others can write, they can exchange what is
/// in there; a sticky folder, as /tmp, keeps them from that.
std::string distrust_way_to(const fs::path& folder) {
  for (fs::path place = folder; place.has_relative_path(); place = place.parent_path()) {
    struct stat status {};
    if (::stat(place.parent_path().c_str(), &status) != 0) continue;  // will be made
    if (others_can_write(status) && (status.st_mode & S_ISVTX) == 0) return others_text(place.parent_path());
  }
  return "";
}

}  // namespace

std::string distrust(const fs::path& folder) {
  std::error_code error;
  struct stat status {};
  if (::stat(folder.c_str(), &status) == 0) {
    if (status.st_uid != ::geteuid()) return folder.string() + " belongs to another user";
    if (others_can_write(status)) return others_text(folder, "empty it, then ");
  }
  std::string way = distrust_way_to(fs::absolute(folder, error).lexically_normal());
  return way.empty() ? distrust_way_to(fs::weakly_canonical(folder, error)) : way;
}

fs::path named_cache_directory() {
  const auto variable = [](const char* name) {
    const char* value = std::getenv(name);
    return fs::path(value ? value : "");
  };
  if (fs::path own = variable("TACTEL_CACHE_DIR"); !own.empty()) return own;
  if (const fs::path cache = variable("XDG_CACHE_HOME"); !cache.empty()) return cache / "tactel";
  if (const fs::path home = variable("HOME"); !home.empty()) return home / ".cache" / "tactel";
  return {};
}

fs::path default_cache_directory() {
  fs::path folder = named_cache_directory();
  return folder.empty() || distrust(folder).empty() ? folder : fs::path();
}

}  // namespace tactel::fem
