// Another vendor's program in ROS's domain, as a ROS 2 node over Fast DDS would be: hears all that
// palpate-crtk publishes below a namespace, and says what it is told on stdin.
//
//   palpate_fastdds_peer DOMAIN NAMESPACE
//   stdin, a line each:   force X Y Z [FRAME]   servo_cf at 200 Hz from now on
//                         quiet                 no servo_cf any more
//                         command WORD          one state_command
//                         report                a line of JSON on stdout
//   It ends with stdin.
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <iostream>
#include <map>
#include <mutex>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/domain/DomainParticipantListener.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <nlohmann/json.hpp>

namespace {

namespace fast = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using Bytes = std::vector<unsigned char>;

constexpr std::uint32_t kMostBytes = 4096;

/// A ROS message as bytes: CDR with its encapsulation.
class RawType : public fast::TopicDataType {
 public:
  explicit RawType(const std::string& name) {
    setName(name.c_str());
    m_typeSize = kMostBytes;
    m_isGetKeyDefined = false;
    auto_fill_type_object(false);
    auto_fill_type_information(false);
  }
  bool serialize(void* data, rtps::SerializedPayload_t* payload) override {
    const Bytes& bytes = *static_cast<Bytes*>(data);
    payload->encapsulation = CDR_LE;
    payload->length = static_cast<std::uint32_t>(bytes.size());
    std::memcpy(payload->data, bytes.data(), bytes.size());
    return true;
  }
  bool deserialize(rtps::SerializedPayload_t* payload, void* data) override {
    static_cast<Bytes*>(data)->assign(payload->data, payload->data + payload->length);
    return true;
  }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] { return static_cast<std::uint32_t>(static_cast<Bytes*>(data)->size()); };
  }
  void* createData() override { return new Bytes; }
  void deleteData(void* data) override { delete static_cast<Bytes*>(data); }
  bool getKey(void*, rtps::InstanceHandle_t*, bool) override { return false; }
};

struct Header {
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
  std::string frame;
};

/// Reads or writes a message with Fast CDR.
class Message {
 public:
  explicit Message(Bytes& bytes)
      : buffer_(reinterpret_cast<char*>(bytes.data()), bytes.size()),
        cdr_(buffer_, eprosima::fastcdr::Cdr::DEFAULT_ENDIAN, eprosima::fastcdr::Cdr::DDS_CDR) {}
  eprosima::fastcdr::Cdr& cdr() { return cdr_; }
  Header ReadHeader() {
    cdr_.read_encapsulation();
    Header header;
    cdr_ >> header.sec >> header.nanosec >> header.frame;
    return header;
  }
  void WriteHeader(const std::string& frame) {
    cdr_.serialize_encapsulation();
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    const auto ns = std::chrono::duration_cast<std::chrono::nanoseconds>(now).count();
    cdr_ << static_cast<std::int32_t>(ns / 1'000'000'000)
         << static_cast<std::uint32_t>(ns % 1'000'000'000) << frame;
  }

 private:
  eprosima::fastcdr::FastBuffer buffer_;
  eprosima::fastcdr::Cdr cdr_;
};

/// A topic to which it listens.
class Heard : public fast::DataReaderListener {
 public:
  explicit Heard(int numbers) : numbers_(numbers) {}

  void on_data_available(fast::DataReader* reader) override {
    Bytes bytes;
    fast::SampleInfo info;
    while (reader->take_next_sample(&bytes, &info) == ReturnCode_t::RETCODE_OK) {
      const auto now = std::chrono::system_clock::now().time_since_epoch();
      if (!info.valid_data) continue;
      const std::lock_guard lock(mutex_);
      Take(bytes, std::chrono::duration_cast<std::chrono::nanoseconds>(now).count(),
           info.sample_identity.sequence_number().to64long());
    }
  }
  nlohmann::json Report() {
    const std::lock_guard lock(mutex_);
    nlohmann::json json{{"count", count_}, {"lost", lost_},      {"frame", frame_},
                        {"stamp", stamp_}, {"numbers", values_}, {"state", state_}};
    if (!delays_us_.empty()) {
      std::vector<double> sorted = delays_us_;
      std::ranges::sort(sorted);
      const auto at = [&](double q) {
        return sorted[static_cast<std::size_t>(q * static_cast<double>(sorted.size() - 1))];
      };
      json["delay_us"] = {{"p50", at(0.5)}, {"p99", at(0.99)}, {"p999", at(0.999)}, {"max", at(1)}};
    }
    return json;
  }

 private:
  void Take(Bytes& bytes, std::int64_t now_ns, std::int64_t sequence) {
    ++count_;
    // Gaps in the writer's numbers are samples that were lost on the way.
    if (next_ != 0 && sequence > next_) lost_ += sequence - next_;
    next_ = sequence + 1;
    Message message(bytes);
    const Header header = message.ReadHeader();
    frame_ = header.frame;
    stamp_ = header.sec + 1e-9 * header.nanosec;
    const std::int64_t stamp_ns = header.sec * std::int64_t{1'000'000'000} + header.nanosec;
    delays_us_.push_back(1e-3 * static_cast<double>(now_ns - stamp_ns));
    if (numbers_ == 0) {
      bool homed = false, busy = false;
      message.cdr() >> state_ >> homed >> busy;
    }
    values_.assign(static_cast<std::size_t>(numbers_), 0.0);
    for (double& value : values_) message.cdr() >> value;
  }

  const int numbers_;
  std::mutex mutex_;
  std::uint64_t count_ = 0;
  std::int64_t next_ = 0, lost_ = 0;
  std::string frame_, state_;
  double stamp_ = 0.0;
  std::vector<double> values_, delays_us_;
};

/// The types that the domain's writers announce.
class Discovery : public fast::DomainParticipantListener {
 public:
  void on_publisher_discovery(fast::DomainParticipant*, rtps::WriterDiscoveryInfo&& info) override {
    const std::lock_guard lock(mutex_);
    const auto& data = info.info.m_qos.m_userData.data_vec();
    writers_[info.info.topicName().to_string()] = {info.info.typeName().to_string(),
                                                   std::string(data.begin(), data.end())};
  }
  nlohmann::json Report() {
    const std::lock_guard lock(mutex_);
    return writers_;
  }

 private:
  std::mutex mutex_;
  std::map<std::string, std::array<std::string, 2>> writers_;
};

template <class T>
T* Made(T* made, const char* what) {
  if (made != nullptr) return made;
  std::fprintf(stderr, "Fast DDS makes no %s\n", what);
  std::exit(1);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const std::string name = argv[2];
  fast::DomainParticipantQos qos;
  qos.transport().use_builtin_transports = false;
  auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  udp->interfaceWhiteList.emplace_back("127.0.0.1");
  qos.transport().user_transports.push_back(udp);
  Discovery discovery;
  auto* const participant = Made(fast::DomainParticipantFactory::get_instance()->create_participant(
                                     static_cast<std::uint32_t>(std::stoul(argv[1])), qos,
                                     &discovery, fast::StatusMask::none()),
                                 "participant");
  for (const char* type :
       {"geometry_msgs::msg::dds_::PoseStamped_", "geometry_msgs::msg::dds_::TwistStamped_",
        "geometry_msgs::msg::dds_::WrenchStamped_", "crtk_msgs::msg::dds_::OperatingState_",
        "crtk_msgs::msg::dds_::StringStamped_"}) {
    fast::TypeSupport(new RawType(type)).register_type(participant);
  }
  auto* const subscriber =
      Made(participant->create_subscriber(fast::SUBSCRIBER_QOS_DEFAULT), "subscriber");
  auto* const publisher =
      Made(participant->create_publisher(fast::PUBLISHER_QOS_DEFAULT), "publisher");
  const auto topic = [&](const std::string& what, const std::string& type) {
    return Made(participant->create_topic("rt" + name + "/" + what, type, fast::TOPIC_QOS_DEFAULT),
                "topic");
  };

  // ROS 2's default quality of service.
  fast::DataReaderQos reads = fast::DATAREADER_QOS_DEFAULT;
  reads.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
  reads.history().kind = fast::KEEP_LAST_HISTORY_QOS;
  reads.history().depth = 10;
  reads.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  fast::DataWriterQos writes = fast::DATAWRITER_QOS_DEFAULT;
  writes.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
  writes.durability().kind = fast::VOLATILE_DURABILITY_QOS;
  writes.history().depth = 10;
  writes.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;

  std::map<std::string, std::unique_ptr<Heard>> heard;
  const auto hear = [&](const std::string& what, const std::string& type, int numbers) {
    auto& listener = heard[what] = std::make_unique<Heard>(numbers);
    Made(subscriber->create_datareader(topic(what, type), reads, listener.get()), "reader");
  };
  hear("measured_cp", "geometry_msgs::msg::dds_::PoseStamped_", 7);
  hear("measured_cv", "geometry_msgs::msg::dds_::TwistStamped_", 6);
  hear("measured_cf", "geometry_msgs::msg::dds_::WrenchStamped_", 6);
  hear("operating_state", "crtk_msgs::msg::dds_::OperatingState_", 0);
  auto* const servo =
      Made(publisher->create_datawriter(
               topic("servo_cf", "geometry_msgs::msg::dds_::WrenchStamped_"), writes),
           "writer");
  auto* const command =
      Made(publisher->create_datawriter(
               topic("state_command", "crtk_msgs::msg::dds_::StringStamped_"), writes),
           "writer");

  std::mutex force_mutex;
  std::array<double, 6> force{};
  std::string frame;
  std::atomic<bool> pulls{false}, ends{false};
  std::thread pulling([&] {
    while (!ends) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      if (!pulls) continue;
      Bytes bytes(kMostBytes);
      Message message(bytes);
      const std::lock_guard lock(force_mutex);
      message.WriteHeader(frame);
      for (const double value : force) message.cdr() << value;
      bytes.resize(message.cdr().getSerializedDataLength());
      servo->write(&bytes);
    }
  });

  std::puts("peer: ready");
  std::fflush(stdout);
  for (std::string line; std::getline(std::cin, line);) {
    std::istringstream words(line);
    std::string verb;
    words >> verb;
    if (verb == "force") {
      const std::lock_guard lock(force_mutex);
      frame.clear();
      words >> force[0] >> force[1] >> force[2] >> frame;
      pulls = true;
    } else if (verb == "quiet") {
      pulls = false;
    } else if (verb == "command") {
      std::string word;
      words >> word;
      Bytes bytes(kMostBytes);
      Message message(bytes);
      message.WriteHeader("");
      message.cdr() << word;
      bytes.resize(message.cdr().getSerializedDataLength());
      command->write(&bytes);
    } else if (verb == "report") {
      nlohmann::json json{{"writers", discovery.Report()}};
      for (auto& [what, listener] : heard) json[what] = listener->Report();
      std::puts(json.dump().c_str());
      std::fflush(stdout);
    }
  }
  ends = true;
  pulling.join();
  participant->delete_contained_entities();
  fast::DomainParticipantFactory::get_instance()->delete_participant(participant);
  return 0;
}
