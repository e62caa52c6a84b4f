#include "tests/support/allocation_counter.h"

#include <cerrno>
#include <cstddef>

namespace palpate::test {
namespace {
// In the executable itself and without a constructor, so that reading it allocates no memory.
constinit thread_local std::uint64_t allocations = 0;
}  // namespace
std::uint64_t AllocationsOfThisThread() {
  return allocations;
}
}  // namespace palpate::test

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
extern "C" {
// glibc's own functions, by the names that it provides for replacements of malloc.
void* __libc_malloc(std::size_t size) noexcept;
void* __libc_calloc(std::size_t count, std::size_t size) noexcept;
void* __libc_realloc(void* p, std::size_t size) noexcept;
void* __libc_memalign(std::size_t align, std::size_t size) noexcept;

void* malloc(std::size_t size) noexcept {
  ++palpate::test::allocations;
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) noexcept {
  ++palpate::test::allocations;
  return __libc_calloc(count, size);
}
void* realloc(void* p, std::size_t size) noexcept {
  ++palpate::test::allocations;
  return __libc_realloc(p, size);
}
void* memalign(std::size_t align, std::size_t size) noexcept {
  ++palpate::test::allocations;
  return __libc_memalign(align, size);
}
void* aligned_alloc(std::size_t align, std::size_t size) noexcept {
  return memalign(align, size);
}
int posix_memalign(void** p, std::size_t align, std::size_t size) noexcept {
  if (align % sizeof(void*) != 0 || (align & (align - 1)) != 0 || align == 0) return EINVAL;
  void* const memory = memalign(align, size);
  if (memory == nullptr) return ENOMEM;
  *p = memory;
  return 0;
}
}
#endif
