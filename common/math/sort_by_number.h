#pragma once

#include <cstddef>
#include <functional>
#include <numeric>
#include <vector>

namespace palpate {

/// The working memory of SortByNumber, which can be reused.
template <class Item>
struct SortRoom {
  std::vector<Item>& sorted;
  std::vector<std::size_t>& place;
};
/// Sorts items by a number below `end` that each has.  Stable, so that sorting by a second number
/// and then by a first sorts by both (radix sort).  Takes two passes over the items and one over
/// the numbers: it sorts the corners and edges of a mesh, by vertex numbers, in a tenth of the time
/// of a comparison sort.
/// @param number_of  gives an item's number: a member or a function.
template <class Item, class NumberOf>
void SortByNumber(std::vector<Item>& items, std::size_t end, NumberOf number_of,
                  const SortRoom<Item>& room) {
  room.place.assign(end + 1, 0);
  for (const Item& item : items) ++room.place[std::invoke(number_of, item) + 1];
  std::partial_sum(room.place.begin(), room.place.end(), room.place.begin());
  room.sorted.resize(items.size());
  for (const Item& item : items) room.sorted[room.place[std::invoke(number_of, item)]++] = item;
  items.swap(room.sorted);
}
template <class Item, class NumberOf>
void SortByNumber(std::vector<Item>& items, std::size_t end, NumberOf number_of) {
  std::vector<Item> sorted;
  std::vector<std::size_t> place;
  SortByNumber(items, end, number_of, SortRoom<Item>{sorted, place});
}

}  // namespace palpate
