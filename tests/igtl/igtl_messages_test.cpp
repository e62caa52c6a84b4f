#include "client/igtl/igtl_messages.h"

#include <cstring>
#include <limits>

#include <gtest/gtest.h>
#include <igtlMessageHeader.h>
#include <igtlSensorMessage.h>
#include <igtlTransformMessage.h>

namespace palpate::test {
namespace {

/// A message as a client of the library reads it.
struct Received {
  igtl::MessageHeader::Pointer header;
  std::vector<std::uint8_t> body;
};

std::vector<Received> ReadAll(const std::vector<std::uint8_t>& bytes) {
  std::vector<Received> all;
  for (std::size_t at = 0; at < bytes.size();) {
    const auto header = igtl::MessageHeader::New();
    header->InitPack();
    const auto head = static_cast<std::size_t>(header->GetPackSize());
    if (at + head > bytes.size()) break;
    std::memcpy(header->GetPackPointer(), bytes.data() + at, head);
    EXPECT_TRUE(header->Unpack(1) & igtl::MessageHeader::UNPACK_HEADER);
    at += head;
    const auto size = static_cast<std::size_t>(header->GetBodySizeToRead());
    EXPECT_LE(at + size, bytes.size());
    if (at + size > bytes.size()) break;
    all.push_back({header, {bytes.data() + at, bytes.data() + at + size}});
    at += size;
  }
  return all;
}

template <class Message>
typename Message::Pointer Unpack(Received& received) {
  typename Message::Pointer message = Message::New();
  message->SetMessageHeader(received.header);
  message->AllocatePack();
  EXPECT_EQ(static_cast<std::size_t>(message->GetPackBodySize()), received.body.size());
  std::memcpy(message->GetPackBodyPointer(), received.body.data(), received.body.size());
  EXPECT_TRUE(message->Unpack(1) & igtl::MessageHeader::UNPACK_BODY) << "its checksum is wrong";
  return message;
}

wire::ToolState Tool() {
  wire::ToolState tool{};
  wire::FromText("hand", tool.station);
  // A quarter turn about the scene's y, up.
  wire::FromPose({Vec3(0.001, 0.002, 0.003), Quat(Eigen::AngleAxisd(EIGEN_PI / 2, Vec3::UnitY()))},
                 tool.graphic_position_m, tool.graphic_orientation_wxyz);
  wire::FromVec3({1, 2, 3}, tool.force_N);
  wire::FromVec3({0.1, 0.2, 0.3}, tool.torque_Nm);
  return tool;
}

TEST(IgtlMessages, AreATransformInMillimetresAndTwoSensorsInRas) {
  auto all = ReadAll(IgtlMessages(Tool(), 1'700'000'000'500'000'000));
  ASSERT_EQ(all.size(), 3u);
  EXPECT_STREQ(all[0].header->GetDeviceName(), "hand");
  EXPECT_STREQ(all[1].header->GetDeviceName(), "hand_force");
  EXPECT_STREQ(all[2].header->GetDeviceName(), "hand_torque");

  igtl::Matrix4x4 m;
  Unpack<igtl::TransformMessage>(all[0])->GetMatrix(m);
  // Right is -x, anterior z, superior y.
  EXPECT_FLOAT_EQ(m[0][3], -1.0f);
  EXPECT_FLOAT_EQ(m[1][3], 3.0f);
  EXPECT_FLOAT_EQ(m[2][3], 2.0f);
  // The tool's own x, which was the scene's, is -z now: posterior.  Its y stays up.
  EXPECT_NEAR(m[1][0], -1.0f, 1e-6);
  EXPECT_NEAR(m[2][1], 1.0f, 1e-6);
  // A rotation: what it makes of x and y stands to each other as z.
  const Vec3 x(m[0][0], m[1][0], m[2][0]), y(m[0][1], m[1][1], m[2][1]),
      z(m[0][2], m[1][2], m[2][2]);
  EXPECT_LT((x.cross(y) - z).norm(), 1e-6);

  const auto force = Unpack<igtl::SensorMessage>(all[1]);
  ASSERT_EQ(force->GetLength(), 3u);
  EXPECT_EQ(force->GetValue(0), -1.0);
  EXPECT_EQ(force->GetValue(1), 3.0);
  EXPECT_EQ(force->GetValue(2), 2.0);
  const auto torque = Unpack<igtl::SensorMessage>(all[2]);
  EXPECT_EQ(torque->GetValue(1), 0.3);
  EXPECT_NE(force->GetUnit(), torque->GetUnit());
  EXPECT_NE(force->GetUnit(), 0u);
}

TEST(IgtlMessages, AreNoneOfAPoseThatIsNotFinite) {
  wire::ToolState tool = Tool();
  tool.graphic_position_m[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(IgtlMessages(tool, 0).empty());
}

TEST(IgtlMessages, TellLongNamesApartThatBeginAlike) {
  const std::string a = IgtlName("a_very_long_name_of_a_station_01"),
                    b = IgtlName("a_very_long_name_of_a_station_02");
  EXPECT_NE(a, b);
  EXPECT_LE((a + "_torque").size(), 20u);
}

}  // namespace
}  // namespace palpate::test
