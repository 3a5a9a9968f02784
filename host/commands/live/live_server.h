// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <string>

namespace tactel::host {

/// Serves a page and, at "/events", lines of JSON as server-sent events (HTML, 9.2), by threads of its own. On this
/// machine's own address it answers to that name alone, so that no page of another site reads it.
class LiveServer {
 public:
  /// place: "PORT", of 127.0.0.1, or "ADDRESS:PORT"; port 0: one that is free. Throws ConfigError where it is neither,
  /// or cannot be listened at.
  LiveServer(const std::string& place, std::string page);
  /// Tells every browser that there is no more.
  ~LiveServer();
  LiveServer(const LiveServer&) = delete;
  LiveServer& operator=(const LiveServer&) = delete;

  std::string address() const;  ///< "http://127.0.0.1:8080/"
  /// Sends a line to every browser. Waits for none: one that lags by kept_lines misses the oldest.
  void send(std::string line);

  static constexpr std::size_t kept_lines = 64;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactel::host
