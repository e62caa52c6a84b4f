#include "devices/haply/inverse_client.h"

#include <chrono>
#include <cstdlib>
#include <exception>
#include <optional>
#include <utility>

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket.hpp>
#include <poll.h>
#include <signal.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "common/error.h"
#include "common/realtime/steady_clock.h"

namespace palpate::haply {
namespace asio = boost::asio;
namespace {

/// After this time without a Send, zero is sent, so that poses keep coming and no force remains.
constexpr int kKeepAlive_ms = 10;
/// After this time without an answer the service counts as dead; the device's forces are off
/// long before.
constexpr std::chrono::milliseconds kDead{1000};
/// Time limit for opening a connection, which may take longer.
constexpr std::chrono::milliseconds kOpening{2000};
constexpr int kRetry_ms = 500;
/// Size limit of a message.  The state of some devices is 2 kB; anything larger is not from an
/// Inverse Service.
constexpr std::size_t kLongestMessage = 1 << 20;

std::string Name(const Address& address) {
  return "ws://" + address.host + ":" + address.port;
}

Error NoService(const Address& address, const std::string& why) {
  return Error("haply: no Inverse Service at " + Name(address) + " (" + why +
               "); install it with the Haply Hub and start it ('sudo systemctl start "
               "haply-inverse-service'), or give its address in " +
               kServiceVariable);
}

void Ring(int eventfd) noexcept {
  const std::uint64_t one = 1;
  if (write(eventfd, &one, sizeof one) < 0) {
    // The event is already signalled.
  }
}

}  // namespace

Address ServiceAddress() {
  Address address;
  const char* variable = std::getenv(kServiceVariable);
  if (!variable || !*variable) return address;
  std::string text = variable;
  if (text.starts_with("ws://")) text = text.substr(5);
  while (text.ends_with('/')) text.pop_back();
  const std::size_t colon = text.rfind(':');
  if (colon == 0 || colon == std::string::npos || colon + 1 == text.size() ||
      text.find_first_not_of("0123456789", colon + 1) != std::string::npos) {
    throw UsageError(std::string(kServiceVariable) + "='" + variable +
                     "': give the service's address as ws://HOST:PORT");
  }
  address.host = text.substr(0, colon);
  address.port = text.substr(colon + 1);
  return address;
}

/// One connection.  Each call waits at most for a given time, or until the stop descriptor becomes
/// readable; calls throw boost::system::system_error.
class InverseClient::Link {
 public:
  /// @param stop  descriptor; -1: none.
  explicit Link(int stop) {
    if (stop < 0) return;
    stop_.assign(dup(stop));
    stop_.async_wait(stop_.wait_read, [this](const auto& error) { stopped_ = !error; });
  }
  void Connect(const Address& address) {
    const auto places = asio::ip::tcp::resolver(io_).resolve(address.host, address.port);
    // localhost has two addresses, and the service may listen at either.
    Await(kOpening, [&](auto done) { asio::async_connect(tcp(), places, done); });
    tcp().set_option(asio::ip::tcp::no_delay(true));  // messages are sent without delay
  }
  /// Throws Error, with the remedy.
  void Open(const Address& address) {
    try {
      Connect(address);
      socket_.read_message_max(kLongestMessage);
      const std::string host = address.host + ":" + address.port;
      Await(kOpening, [&](auto done) { socket_.async_handshake(host, "/", done); });
    } catch (const boost::system::system_error& error) {
      throw NoService(address, error.code().message());
    }
    socket_.text(true);
  }
  void Write(const std::string& text) {
    Await(kDead, [&](auto done) { socket_.async_write(asio::buffer(text), done); });
  }
  /// Does not wait.
  void WriteLast(const std::string& text) {
    tcp().non_blocking(true);
    socket_.write(asio::buffer(text));
  }
  const std::string& Read(std::chrono::milliseconds most = kDead) {
    buffer_.clear();
    Await(most, [&](auto done) { socket_.async_read(buffer_, done); });
    text_.assign(static_cast<const char*>(buffer_.data().data()), buffer_.size());
    return text_;
  }

 private:
  template <class Begin>
  void Await(std::chrono::milliseconds most, Begin begin) {
    std::optional<boost::system::error_code> ended;
    io_.restart();
    begin([&ended](const boost::system::error_code& error, const auto&...) { ended = error; });
    const auto until = std::chrono::steady_clock::now() + most;
    while (!ended && !stopped_ && io_.run_one_until(until) > 0) {
    }
    if (!ended) {
      boost::system::error_code ignored;
      tcp().close(ignored);
      while (!ended) io_.run_one();  // the cancelled operation ends with an error
      ended = stopped_ ? asio::error::operation_aborted : asio::error::timed_out;
    }
    if (*ended) throw boost::system::system_error(*ended);
  }
  // Uses the loop's own executor, because Asio's any_io_executor adds 1.4 s to 12 s of compilation.
  using Executor = asio::io_context::executor_type;
  using Socket = asio::basic_stream_socket<asio::ip::tcp, Executor>;

  Socket& tcp() { return socket_.next_layer(); }

  asio::io_context io_{1};
  asio::posix::basic_stream_descriptor<Executor> stop_{io_};
  bool stopped_ = false;
  boost::beast::websocket::stream<Socket, false> socket_{io_};
  boost::beast::flat_buffer buffer_;
  std::string text_;
};

void CheckService(const Address& address) {
  try {
    InverseClient::Link(-1).Connect(address);
  } catch (const boost::system::system_error& error) {
    throw NoService(address, error.code().message());
  }
}

InverseClient::InverseClient(Address address, std::string wanted, const RealtimeOptions& realtime)
    : address_(std::move(address)),
      wanted_(std::move(wanted)),
      realtime_(realtime),
      wake_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
      stop_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  std::future<void> opened = opened_.get_future();
  thread_ = std::thread([this] { Run(); });
  try {
    opened.get();
  } catch (...) {
    thread_.join();
    close(wake_);
    close(stop_);
    throw;
  }
}

InverseClient::~InverseClient() {
  Ring(stop_);
  thread_.join();
  close(wake_);
  close(stop_);
}

void InverseClient::Send(const Vec3& force_W) noexcept {
  forces_.Write(force_W);
  Ring(wake_);
}

void InverseClient::Say(std::string DeviceNews::*where, const std::string& news) {
  const std::lock_guard lock(news_mutex_);
  AddLine(news_.*where, news);
}

DeviceNews InverseClient::TakeNews() {
  const std::lock_guard lock(news_mutex_);
  return std::exchange(news_, {});
}

void InverseClient::Run() {
  sigset_t all;
  sigfillset(&all);
  pthread_sigmask(SIG_BLOCK, &all, nullptr);
  bool opened = false;
  std::string trouble;
  for (;;) {
    try {
      if (!opened && realtime_.mode != RealtimeMode::kOff) EnterRealtime(realtime_);
      Link link(stop_);
      link.Open(address_);
      // The service sends the first message.
      const Inventory inventory = ParseInventory(link.Read(kOpening), wanted_);
      if (!opened) {
        // After a reconnection it must be the same device, because the user still holds that one.
        inventory_ = inventory;
        wanted_ = inventory.device_id;
        opened = true;
        opened_.set_value();
      } else {
        Say(&DeviceNews::notes, "the Inverse Service is back");
      }
      trouble.clear();
      Serve(link);
      return;
    } catch (const boost::system::system_error& error) {
      if (!opened) {
        opened_.set_exception(std::make_exception_ptr(NoService(address_, error.code().message())));
        return;
      }
      if (trouble.empty()) {
        trouble = "the Inverse Service has gone (" + error.code().message() +
                  "): no force until it is back; see 'journalctl -u haply-inverse-service'";
        Say(&DeviceNews::faults, trouble);
      }
    } catch (const std::exception& error) {
      if (!opened) {
        opened_.set_exception(std::current_exception());
        return;
      }
      if (error.what() != trouble) Say(&DeviceNews::faults, trouble = error.what());
    }
    state_.up = false;
    states_.Write(state_);
    pollfd wait{stop_, POLLIN, 0};
    if (poll(&wait, 1, kRetry_ms) > 0) return;
  }
}

/// Serves until it is to stop; throws boost::system::system_error if the connection ends.
void InverseClient::Serve(Link& link) {
  for (bool first = true;; first = false) {
    pollfd wait[2] = {{wake_, POLLIN, 0}, {stop_, POLLIN, 0}};
    if (!first) poll(wait, 2, kKeepAlive_ms);
    Vec3 force = Vec3::Zero();
    if (wait[1].revents != 0) {
      link.WriteLast(ForceMessage(inventory_, force));
      return;
    }
    std::uint64_t rung = 0;
    if (wait[0].revents != 0 && read(wake_, &rung, sizeof rung) == sizeof rung) {
      forces_.Read(force);
    }
    const std::string message = ForceMessage(inventory_, force, first);
    const std::int64_t sent_ns = SteadyNanoseconds();
    link.Write(message);
    const std::string& reply = link.Read();
    state_.round_trip_ns = SteadyNanoseconds() - sent_ns;
    Take(reply);
  }
}

void InverseClient::Take(const std::string& reply) {
  const Lie lie = ParseReply(reply, inventory_, state_.reading);
  if (lie != state_.lie) {
    if (lie == Lie::kNone) {
      Say(&DeviceNews::notes, "the Inverse Service is in order again");
    } else {
      Say(&DeviceNews::faults, TextOf(lie));
    }
  }
  state_.lie = lie;
  state_.up = true;
  ++state_.replies;
  states_.Write(state_);
}

}  // namespace palpate::haply
