#pragma once

#include <cstddef>
#include <functional>
#include <numeric>
#include <vector>

namespace palpate {

/// What sorting takes, which may be used again.
template <class Item>
struct SortRoom {
  std::vector<Item>& sorted;
  std::vector<std::size_t>& place;
};
/// Sorts items by a number below `end` that each of them has; those of the same number stay in
/// their order, so that sorting by a second number and then by a first sorts by both (radix sort).
/// Two passes over the items and one over the numbers: the corners and edges of a mesh, whose ends
/// are numbers of vertices, are sorted in a tenth of the time that comparing them takes.
/// @param number_of  a member or a function.
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
