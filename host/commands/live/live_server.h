// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "hw/descriptor.h"

namespace tactel::host {

/// A socket that listens, and where browsers find it.
struct Listening {
  hw::Descriptor socket;            ///< accepting never waits
  std::string address;              ///< "http://127.0.0.1:8080/", of this machine
  std::vector<std::string> others;  ///< the same for other machines; empty: none reach it, or there is one address
};

/// Listens at "PORT", of 127.0.0.1, or at "ADDRESS:PORT": "[::1]:8080", "localhost:8080"; "0.0.0.0:8080", "*:8080" and
/// ":8080" are all addresses. Port 0: one that is free. Throws ConfigError where it is neither, or with the reason why
/// it cannot be listened at.
Listening listen_at(const std::string& place);

/// Throws ConfigError where --serve-host is no name of a host.
void check_serve_host(const std::string& name);

/// Serves a page and, at "/events", lines of JSON as server-sent events (HTML, 9.2), by one thread of its own, whose
/// work, memory and descriptors are bounded whatever comes: a GET of these two, a head of 8 kB in 5 s, 64 browsers and
/// no more than a fourth of the descriptors that this process may have. Who holds a place without a request gives it
/// up to the next; 503 goes to those beyond. It answers to this machine's names and addresses alone (answers_to).
class LiveServer {
 public:
  /// place: as of listen_at, whose errors it throws. hosts: further names that it answers to.
  LiveServer(const std::string& place, std::string page, std::vector<std::string> hosts = {});
  /// Tells every browser that there is no more. Takes 0.3 s at most.
  ~LiveServer();

  const std::string& address() const;              ///< as of Listening
  const std::vector<std::string>& others() const;  ///< the same
  /// Sends a line to every browser; event: its name, none for a frame's. Waits for nothing: where the server is busy
  /// the next one takes it along, and a browser that lags by kept_lines misses the oldest.
  void send(const std::string& line, const char* event = nullptr);

  static constexpr std::size_t kept_lines = 64;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactel::host
