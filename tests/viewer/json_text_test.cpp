#include "client/viewer/json_text.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace palpate {
namespace {

TEST(JsonText, ReplacesWhatIsNotUtf8AndIsReadAgain) {
  const std::string text = ToText(nlohmann::json({{"name", "caf\xe9 \xc3\xa9"}}));
  EXPECT_EQ(nlohmann::json::parse(text)["name"], "caf\xef\xbf\xbd \xc3\xa9");
}

}  // namespace
}  // namespace palpate
