// Somebody who tries to say or hear what is not for him, in a process of his own: a process has one
// identity.
//   rogue DOMAIN IDENTITY|- SECONDS write|read TOPIC [write|read TOPIC]...
// Prints of each, in a line or two, `not allowed: …`, or `matched N`, and for a reader `heard N`;
// on the way, with each hundredth sample, `hears N`, and with each that it has had before `again`.
// What it writes is numbered.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <set>
#include <string>
#include <thread>

#include "common/dds/endpoint.h"
#include "common/dds/participant.h"
#include "common/dds/topics.h"
#include "common/error.h"

namespace palpate::dds {
namespace {

using std::chrono::steady_clock;

struct Order {
  bool write;
  std::string topic;
  double seconds;
};

template <class T>
std::uint64_t* NumberOf(T& sample) {
  if constexpr (requires { sample.pose_sequence; }) return &sample.pose_sequence;
  if constexpr (requires { sample.request; }) return &sample.request;
  return nullptr;
}

template <class T>
void Try(const Participant& participant, const Order& order, Qos qos) {
  const auto end = steady_clock::now() + std::chrono::duration<double>(order.seconds);
  int matched = 0, heard = 0;
  std::set<std::uint64_t> numbers;
  const auto go_on = [&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    return steady_clock::now() < end;
  };
  if (order.write) {
    Writer<T> writer(participant, order.topic, qos);
    for (T sample{}; go_on(); writer.Write(sample)) {
      matched = std::max(matched, writer.matched_readers());
      if (std::uint64_t* const number = NumberOf(sample)) ++*number;
    }
    std::printf("matched %d\n", matched);
  } else {
    // Every sample, as the server's readers of requests take it.
    Reader<T> reader(participant, order.topic,
                     qos == Qos::kSession ? Qos::kRecordSession : Qos::kRecord);
    while (go_on()) {
      matched = std::max(matched, reader.matched_writers());
      for (T sample{}; reader.Take(sample);) {
        const std::uint64_t* const number = NumberOf(sample);
        if (number && !numbers.insert(*number).second) std::puts("again");
        if (++heard % 100 == 0) std::printf("hears %d\n", heard);
      }
    }
    std::printf("matched %d\nheard %d\n", matched, heard);
  }
}

/// The rogue's participants, each made when first needed.
class Rogue {
 public:
  Rogue(int domain, const std::string& identity) : domain_(domain) {
    if (identity != "-") network_.identity = identity;
  }
  const Participant& In(bool loop_domain) {
    if (loop_domain) {
      if (!loop_) loop_ = Participant::Loop(domain_, {Transport::kUdp, ""}, network_);
      return *loop_;
    }
    if (!service_) service_ = Participant::Service(domain_, network_);
    return *service_;
  }

 private:
  int domain_;
  Network network_;
  std::optional<Participant> loop_, service_;
};

void Run(Rogue& rogue, const Order& order) {
  const Participant& participant =
      rogue.In(order.topic.ends_with("/pose") || order.topic.ends_with("/wrench"));
  if (order.topic.ends_with("/pose")) return Try<wire::HapticPose>(participant, order, Qos::kLoop);
  if (order.topic.ends_with("/wrench")) return Try<wire::Wrench>(participant, order, Qos::kLoop);
  if (order.topic == kToolStateTopic) {
    return Try<wire::ToolState>(participant, order, Qos::kStream);
  }
  if (order.topic == kSessionStateTopic) {
    return Try<wire::SessionState>(participant, order, Qos::kSession);
  }
  if (order.topic == kSessionRequestTopic) {
    return Try<wire::SessionRequest>(participant, order, Qos::kSession);
  }
  if (order.topic == kOperateRequestTopic) {
    return Try<wire::OperateRequest>(participant, order, Qos::kSession);
  }
  throw Error("rogue knows no topic " + order.topic);
}

}  // namespace
}  // namespace palpate::dds

int main(int argc, char** argv) {
  if (argc < 6 || argc % 2 != 0) return 2;
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  palpate::dds::Rogue rogue(std::atoi(argv[1]), argv[2]);
  int refused = 0;
  for (int i = 4; i < argc; i += 2) {
    try {
      palpate::dds::Run(rogue, {std::string(argv[i]) == "write", argv[i + 1], std::atof(argv[3])});
    } catch (const palpate::Error& error) {
      std::printf("not allowed: %s\n", error.what());
      refused = 1;
    }
  }
  return refused;
}
