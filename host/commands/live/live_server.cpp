// SPDX-License-Identifier: Apache-2.0
#include "host/commands/live/live_server.h"

#include <fmt/format.h>
#include <httplib.h>
#include <sys/socket.h>

#include <charconv>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>

#include "host/support/errors.h"
#include "host/support/interrupt.h"

namespace tactel::host {
namespace {

constexpr std::size_t most_browsers = 16;          // each holds a thread
constexpr auto silence = std::chrono::seconds(2);  // then a comment shows whether a browser is still there

struct Place {
  std::string address = "127.0.0.1";
  int port = 0;
};

[[noreturn]] void refuse(const std::string& place, const std::string& fix) {
  throw ConfigError("command line", "--serve", place, fix);
}

Place place_of(const std::string& text) {
  Place place;
  const std::size_t colon = text.rfind(':');
  const std::string port = colon == std::string::npos ? text : text.substr(colon + 1);
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), place.port);
  if (error != std::errc() || end != port.data() + port.size() || place.port < 0 || place.port > 65535)
    refuse(text, "PORT or ADDRESS:PORT, a port of 0 to 65535");
  if (colon != std::string::npos) place.address = text.substr(0, colon);
  return place;
}

bool own(const std::string& address) { return address.starts_with("127.") || address == "localhost"; }

}  // namespace

struct LiveServer::State {
  State(const std::string& text, std::string page) : place(place_of(text)) {
    server.new_task_queue = [] { return new httplib::ThreadPool(most_browsers); };
    server.set_pre_routing_handler([this](const httplib::Request& request, httplib::Response& response) {
      const std::string host = request.get_header_value("Host");
      if (!own(place.address) || own(host.substr(0, host.rfind(':'))))
        return httplib::Server::HandlerResponse::Unhandled;
      response.status = 403;
      return httplib::Server::HandlerResponse::Handled;
    });
    server.Get("/", [page = std::move(page)](const httplib::Request&, httplib::Response& response) {
      response.set_content(page, "text/html; charset=utf-8");
    });
    server.Get("/events", [this](const httplib::Request&, httplib::Response& response) {
      response.set_header("Cache-Control", "no-store");
      response.set_chunked_content_provider(
          "text/event-stream",
          [this, next = opened()](std::size_t, httplib::DataSink& sink) mutable { return send_next(sink, next); },
          [this](bool) {
            const std::lock_guard lock(mutex);
            --streams;
            more.notify_all();
          });
    });
    server.set_keep_alive_timeout(1);           // s
    server.set_socket_options([](int socket) {  // not SO_REUSEPORT: a port that is taken is one
      const int yes = 1;
      setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    });
    const int port = place.port > 0 ? (server.bind_to_port(place.address, place.port) ? place.port : -1)
                                    : server.bind_to_any_port(place.address);
    if (port <= 0) refuse(text, "an address of this machine and a port that is free: 0 takes one");
    place.port = port;
    const HeldSignals held(HeldSignals::always);
    listening = std::thread([this] { server.listen_after_bind(); });
    while (!server.is_running()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  ~State() {
    {
      std::unique_lock lock(mutex);
      ended = true;
      more.notify_all();
      more.wait_for(lock, silence, [&] { return streams == 0; });
    }
    server.stop();
    listening.join();
  }
  /// Returns the number of the newest line, with which a stream begins.
  std::size_t opened() {
    const std::lock_guard lock(mutex);
    ++streams;
    return lines.empty() ? sent : sent - 1;
  }

  /// In a browser's thread: waits for lines from number `next` on and sends them; false ends the stream.
  bool send_next(httplib::DataSink& sink, std::size_t& next) {
    std::string text;
    bool last = false;
    {
      std::unique_lock lock(mutex);
      more.wait_for(lock, silence, [&] { return ended || next < sent; });
      next = std::max(next, sent - lines.size());
      for (; next < sent; ++next) text += fmt::format("data: {}\n\n", lines[next + lines.size() - sent]);
      last = ended;
    }
    if (text.empty()) text = ": nothing new\n\n";
    if (last) text += "event: end\ndata: the source has ended\n\n";
    if (!sink.write(text.data(), text.size())) return false;
    if (last) sink.done();
    return true;
  }

  Place place;
  std::mutex mutex;  ///< of the next five
  std::condition_variable more;
  std::deque<std::string> lines;  ///< the newest
  std::size_t sent = 0;           ///< lines so far
  int streams = 0;                ///< open ones
  bool ended = false;
  httplib::Server server;
  std::thread listening;
};

LiveServer::LiveServer(const std::string& place, std::string page)
    : state_(std::make_unique<State>(place, std::move(page))) {}
LiveServer::~LiveServer() = default;

std::string LiveServer::address() const {
  return fmt::format("http://{}:{}/", state_->place.address, state_->place.port);
}

void LiveServer::send(std::string line) {
  {
    const std::lock_guard lock(state_->mutex);
    state_->lines.push_back(std::move(line));
    ++state_->sent;
    if (state_->lines.size() > kept_lines) state_->lines.pop_front();
  }
  state_->more.notify_all();
}

}  // namespace tactel::host
