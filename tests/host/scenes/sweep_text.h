// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "host/scenes/scene_source.h"
#include "host/support/errors.h"
#include "tests/host/support/run_tactel.h"
#include "tests/thrown_message.h"

namespace tactel::host {

/// The contacts of a sweep file with this text, of lines or pads.
template <class Source = SceneSource>
Source source(const std::string& text) {
  const ScratchFolder folder;
  return Source::read(folder.write("sweep.toml", text));
}
inline PadSource pads(const std::string& text) { return source<PadSource>(text); }

/// What is said of the text where it is refused.
template <class Source = SceneSource>
std::string message_of(const std::string& text) {
  return thrown_message<ConfigError>([&] { source<Source>(text); });
}

}  // namespace tactel::host
