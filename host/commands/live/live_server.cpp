// SPDX-License-Identifier: Apache-2.0
#include "host/commands/live/live_server.h"

#include <fmt/format.h>
#include <poll.h>
#include <sched.h>
#include <sys/eventfd.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <deque>
#include <mutex>
#include <thread>

#include "host/commands/live/http_head.h"
#include "host/support/errors.h"
#include "host/support/interrupt.h"
#include "host/support/seconds.h"

namespace tactel::host {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t most_clients = 64, least_clients = 4, most_refused = 16;
constexpr std::size_t longest_head = 8192, longest_piece = 1 << 16;  // bytes
constexpr auto look_around = 100ms;                                  // deadlines are looked at so often
constexpr auto for_a_head = 5s, for_a_page = 30s, without_progress = 5s, for_the_rest = 1s, undisturbed = 1s;
constexpr auto quiet_stream = 2s;  // then a comment shows whether a browser is still there
constexpr auto farewell = 300ms;

/// A quarter of the descriptors that this process may have, 64 at most: the frames' own stay free.
std::size_t clients_allowed() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return least_clients;
  return std::clamp<std::size_t>(limit.rlim_cur / 4, least_clients, most_clients);
}

/// A connection: reads a head, then sends what it asked for, then waits a moment for the browser to close, as a reset
/// would take the answer away from it.
struct Client {
  enum class Stage { head, page, stream, closing, gone };

  explicit Client(int file) : socket(file) {}
  /// Begins to send what is a whole response.
  void answer(std::string text) { out = std::move(text), stage = Stage::page, deadline = Clock::now() + for_a_page; }
  bool is_served() const { return stage != Stage::closing; }
  /// Says that there is no more; what still comes is read for a moment.
  void end() {
    ::shutdown(socket, SHUT_WR);
    stage = Stage::closing, deadline = Clock::now() + for_the_rest;
  }
  void close() {
    ::close(socket);
    stage = Stage::gone;
  }

  int socket;
  Stage stage = Stage::head;
  Clock::time_point opened = Clock::now(), deadline = opened + for_a_head, said = opened;
  std::string in{}, out{};
  std::size_t next = 0;  ///< of a stream: number of the next message
};

}  // namespace

struct LiveServer::State {
  State(const std::string& place, std::string text, std::vector<std::string> names)
      : at(listen_at(place)),
        page(std::move(text)),
        hosts(std::move(names)),
        wake(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
    page = response_head(200, "text/html; charset=utf-8", static_cast<std::ptrdiff_t>(page.size())) + page;
    clients.reserve(allowed + most_refused);
    const HeldSignals held(HeldSignals::always);
    listening = std::thread([this] { serve(); });
  }
  ~State() {
    {
      const std::lock_guard lock(mutex);
      hand_over();
      ended = true;
    }
    ring();
    listening.join();
    for (Client& client : clients) client.close();
  }

  /// Of the thread that sends, which holds the mutex.
  void hand_over() {
    for (std::string& message : waiting) arrived.push_back(std::move(message));
    waiting.clear();
    while (arrived.size() > kept_lines) arrived.pop_front();
  }

  /// Takes what was handed over.
  void collect() {
    std::deque<std::string> fresh;
    {
      const std::lock_guard lock(mutex);
      fresh.swap(arrived);
      over = ended;
    }
    for (std::string& message : fresh) messages.push_back(std::move(message)), ++sent;
    while (messages.size() > kept_lines) messages.pop_front();
  }

  void ring() const {
    const std::uint64_t wakes = 1;
    [[maybe_unused]] const auto written = ::write(wake, &wakes, sizeof wakes);
  }

  void serve() {
    // Frames come first where chrt gave them a class of their own.
    const sched_param none{};
    ::sched_setscheduler(0, SCHED_OTHER, &none);
    while (!over) try_turn(look_around);
    const auto until = Clock::now() + farewell;
    do try_turn(10ms);
    while (Clock::now() < until && streams_wait());
  }

  void try_turn(std::chrono::milliseconds longest) try {
    turn_of(longest);
  } catch (const std::exception&) {  // no memory: later
  }

  bool streams_wait() const {
    return std::ranges::any_of(
        clients, [](const Client& client) { return client.stage == Client::Stage::stream && !client.out.empty(); });
  }

  /// Waits for something to do and does it.
  void turn_of(std::chrono::milliseconds longest) {
    std::array<pollfd, most_clients + most_refused + 2> wanted;
    const std::size_t count = clients.size();
    wanted[0] = {wake, POLLIN, 0};
    wanted[1] = {Clock::now() < next_accept ? -1 : at.socket, POLLIN, 0};
    for (std::size_t i = 0; i < count; ++i) wanted[i + 2] = {clients[i].socket, wishes(clients[i]), 0};
    ::poll(wanted.data(), count + 2, static_cast<int>(longest.count()));
    std::uint64_t rung = 0;
    [[maybe_unused]] const auto taken = ::read(wake, &rung, sizeof rung);
    collect();
    for (std::size_t i = 0; i < count; ++i) {
      try {
        attend(clients[i], wanted[i + 2].revents);
      } catch (const std::exception&) {  // no memory: the others go on
        clients[i].close();
      }
    }
    std::erase_if(clients, [](const Client& client) { return client.stage == Client::Stage::gone; });
    if (wanted[1].revents != 0) accept_some();
  }

  static short wishes(const Client& client) {
    return static_cast<short>((client.stage == Client::Stage::page ? 0 : POLLIN) | (client.out.empty() ? 0 : POLLOUT));
  }

  void attend(Client& client, short events) {
    if ((events & (POLLERR | POLLNVAL)) != 0 || ((events & POLLIN) != 0 && !receive(client))) return client.close();
    if (client.stage == Client::Stage::stream && client.out.empty()) fill(client);
    if (!client.out.empty() && !transmit(client)) return client.close();
    if (Clock::now() < client.deadline) return;
    if (client.stage != Client::Stage::head || client.in.empty()) return client.close();
    client.answer(refusal(408, "no whole request within 5 s"));
  }

  /// Takes what came; false where the other side has closed.
  bool receive(Client& client) {
    std::array<char, longest_head> bytes;
    const ssize_t size = ::recv(client.socket, bytes.data(), bytes.size(), 0);
    if (size == 0 || (size < 0 && errno != EAGAIN && errno != EINTR)) return false;
    if (size < 0 || client.stage != Client::Stage::head) return true;  // what follows a request is nothing
    const std::size_t from = client.in.size() < 3 ? 0 : client.in.size() - 3;
    client.in.append(bytes.data(), static_cast<std::size_t>(size));
    const std::size_t end = client.in.find("\r\n\r\n", from);
    if (std::min(end, client.in.size()) + (end == std::string::npos ? 0 : 4) > longest_head)
      client.answer(refusal(431, "a head of more than 8 kB"));
    else if (end != std::string::npos)
      begin(client, read_head(std::string_view(client.in).substr(0, end + 4), hosts));
    else if (client.in[0] < 'A' || client.in[0] > 'Z')
      client.answer(refusal(400, "no request of HTTP/1.1; this page is at http://, not https://"));
    return true;
  }

  void begin(Client& client, const HttpRequest& request) {
    client.in = std::string();
    if (request.status == 403)
      client.answer(
          refusal(403, fmt::format("\"{}\" is no name of this machine; to let pages of that name read the sensor, "
                                   "start monitor with --serve-host {}",
                                   request.asked, request.asked.substr(0, request.asked.rfind(':')))));
    else if (request.status != 200)
      client.answer(
          refusal(request.status, request.status == 405 ? "GET alone" : "no request of HTTP/1.1 with one Host"));
    else if (request.path == "/")
      client.answer(page);
    else if (request.path != "/events")
      client.answer(refusal(404, "/ and /events are all"));
    else
      open_stream(client);
  }

  /// A stream begins with the newest line.
  void open_stream(Client& client) {
    client.stage = Client::Stage::stream;
    client.out = response_head(200, "text/event-stream", -1);
    client.deadline = Clock::now() + without_progress;
    client.next = messages.empty() ? sent : sent - 1;
  }

  /// Takes what a stream has not sent yet, in pieces.
  void fill(Client& client) {
    const auto now = Clock::now();
    client.next = std::max(client.next, sent - messages.size());
    for (; client.next < sent && client.out.size() < longest_piece; ++client.next)
      client.out += messages[client.next + messages.size() - sent];
    if (over && client.next == sent) {
      client.out += "event: end\ndata: the source has ended\n\n";
      client.next = sent + 1;
    }
    if (client.out.empty() && now - client.said >= quiet_stream) client.out = ": nothing new\n\n";
    if (!client.out.empty()) client.said = now;
    client.deadline = now + without_progress;
  }

  /// Sends what the connection takes; false where it is broken.
  static bool transmit(Client& client) {
    const ssize_t size = ::send(client.socket, client.out.data(), client.out.size(), MSG_NOSIGNAL);
    if (size < 0) return errno == EAGAIN || errno == EINTR;
    client.out.erase(0, static_cast<std::size_t>(size));
    if (client.stage == Client::Stage::stream) client.deadline = Clock::now() + without_progress;
    if (client.stage != Client::Stage::page || !client.out.empty()) return true;
    client.end();
    return true;
  }

  void accept_some() {
    for (std::size_t k = 0; k < most_refused; ++k) {
      const int file = ::accept4(at.socket, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
      if (file < 0 && (errno == ECONNABORTED || errno == EINTR)) continue;
      if (file < 0) {
        if (errno != EAGAIN) next_accept = Clock::now() + look_around;  // no descriptor, no memory
        return;
      }
      Client client(file);
      if (!has_room()) turn_away(client);
      if (clients.size() < allowed + most_refused)
        clients.push_back(std::move(client));
      else
        client.close();
    }
  }

  /// Whether one more may be served: where all places are taken, the oldest that has asked for nothing in a second
  /// gives up its own.
  bool has_room() {
    if (std::ranges::count_if(clients, &Client::is_served) < static_cast<std::ptrdiff_t>(allowed)) return true;
    const auto idle = std::ranges::find_if(clients, [now = Clock::now()](const Client& client) {
      return client.stage == Client::Stage::head && now - client.opened > undisturbed;
    });
    if (idle == clients.end()) return false;
    idle->close();
    clients.erase(idle);
    return true;
  }

  void turn_away(Client& client) const {
    ::send(client.socket, crowded.data(), crowded.size(), MSG_NOSIGNAL);
    client.end();
  }

  const Listening at;
  std::string page;  ///< with its head
  const std::vector<std::string> hosts;
  const std::size_t allowed = clients_allowed();
  const std::string crowded = refusal(503, fmt::format("{} browsers are here already", allowed));
  std::deque<std::string> waiting;  ///< of the thread that sends: what the next message takes along
  std::mutex mutex;                 ///< of the next two, held for a swap
  std::deque<std::string> arrived;
  bool ended = false;
  std::deque<std::string> messages;  ///< of the server's thread, and all below: the newest, as they are sent
  std::size_t sent = 0;              ///< messages so far
  bool over = false;                 ///< there will be no more
  hw::Descriptor wake;               ///< an eventfd: there is something new
  std::vector<Client> clients;       ///< by age
  Clock::time_point next_accept{};
  std::thread listening;
};

LiveServer::LiveServer(const std::string& place, std::string page, std::vector<std::string> hosts)
    : state_(std::make_unique<State>(place, std::move(page), std::move(hosts))) {}
LiveServer::~LiveServer() = default;

const std::string& LiveServer::address() const { return state_->at.address; }
const std::vector<std::string>& LiveServer::others() const { return state_->at.others; }

void LiveServer::send(const std::string& line, const char* event) {
  std::string message = event ? fmt::format("event: {}\ndata: {}\n\n", event, line) : fmt::format("data: {}\n\n", line);
  state_->waiting.push_back(std::move(message));
  if (state_->waiting.size() > kept_lines) state_->waiting.pop_front();
  // Nobody waits for the server's thread, which may have been put off while it held the lock.
  if (const std::unique_lock lock(state_->mutex, std::try_to_lock); lock) state_->hand_over();
  state_->ring();
}

}  // namespace tactel::host
