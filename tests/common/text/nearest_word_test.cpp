#include "common/text/nearest_word.h"

#include <gtest/gtest.h>

namespace palpate {
namespace {

TEST(NearestWord, IsTheOneThatAWrongWordWasMeantToBeOrNone) {
  EXPECT_EQ(NearestWord("paretto", {"accuracy", "pareto", "qp"}), "pareto");
  EXPECT_EQ(NearestWord("--scen", {"--seed", "--scene", "--script"}), "--scene");
  EXPECT_EQ(NearestWord("elephant", {"accuracy", "pareto", "qp"}), "");
  EXPECT_EQ(NearestWord("x", {}), "");
}

}  // namespace
}  // namespace palpate
