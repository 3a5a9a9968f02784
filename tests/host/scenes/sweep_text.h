// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "host/scenes/scene_source.h"
#include "host/support/errors.h"
#include "tests/host/support/run_tactel.h"
#include "tests/thrown_message.h"

namespace tactel::host {

/// The contacts of a sweep file with this text.
inline SceneSource source(const std::string& text) {
  const ScratchFolder folder;
  return SceneSource::read(folder.write("sweep.toml", text));
}

/// What is said of the text where it is refused.
inline std::string message_of(const std::string& text) {
  return thrown_message<ConfigError>([&] { source(text); });
}

}  // namespace tactel::host
