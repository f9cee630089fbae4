#pragma once
// Encryption of labels: libsodium's secretbox (XSalsa20 and Poly1305) under a random key, and a
// commitment BLAKE2b(salt, text).

#include <cstdint>
#include <filesystem>
#include <string>

namespace jaculus::testbed {

/// Writes labels.sealed and commitment.txt into `folder`, key and salt into `key` (readable by its
/// owner alone).
void lock_labels(const std::string& text, const std::filesystem::path& folder,
                 const std::filesystem::path& key);

/// The text. InputError where the key is none, or labels or commitment are not those that were
/// encrypted with it.
std::string unlock_labels(const std::filesystem::path& folder, const std::filesystem::path& key);

/// The first 63 bits of the BLAKE2b of a commit's hash (40 hex digits). InputError for anything
/// else.
std::uint64_t seed_of_hash(const std::string& hash);

}  // namespace jaculus::testbed
