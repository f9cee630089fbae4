#include "testbed/vault.h"

#include <fmt/format.h>
#include <sodium.h>

#include <array>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "jaculus/core/error.h"
#include "jaculus/trajectory/csv.h"

namespace jaculus::testbed {
namespace {

using Bytes = std::vector<unsigned char>;
constexpr std::size_t kSalt = 32;

void start() {
  if (sodium_init() < 0) throw std::runtime_error("libsodium does not start");
}

std::string hex(const Bytes& bytes) {
  std::string text(2 * bytes.size() + 1, '\0');
  sodium_bin2hex(text.data(), text.size(), bytes.data(), bytes.size());
  text.pop_back();
  return text;
}

/// Empty where the text is no hex.
Bytes from_hex(const std::string& text) {
  Bytes bytes(text.size() / 2);
  std::size_t length = 0;
  if (sodium_hex2bin(bytes.data(), bytes.size(), text.data(), text.size(), nullptr, &length,
                     nullptr) != 0 ||
      2 * length != text.size()) {
    return {};
  }
  return bytes;
}

std::string read_text(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in)
    throw InputError(
        fmt::format("{}: can't be read; allowed: a file of `testbed seal`", file.string()));
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

std::string commitment_of(const Bytes& salt, const std::string& text) {
  Bytes hash(crypto_generichash_BYTES);
  crypto_generichash(hash.data(), hash.size(), reinterpret_cast<const unsigned char*>(text.data()),
                     text.size(), salt.data(), salt.size());
  return hex(hash);
}

}  // namespace

void lock_labels(const std::string& text, const std::filesystem::path& folder,
                 const std::filesystem::path& key) {
  start();
  Bytes secret(crypto_secretbox_KEYBYTES), salt(kSalt), nonce(crypto_secretbox_NONCEBYTES);
  for (Bytes* bytes : {&secret, &salt, &nonce}) randombytes_buf(bytes->data(), bytes->size());
  Bytes box(text.size() + crypto_secretbox_MACBYTES);
  crypto_secretbox_easy(box.data(), reinterpret_cast<const unsigned char*>(text.data()),
                        text.size(), nonce.data(), secret.data());
  trajectory::write_file(folder / "labels.sealed", hex(nonce) + hex(box) + "\n");
  trajectory::write_file(folder / "commitment.txt", commitment_of(salt, text) + "\n");
  trajectory::write_file(key, hex(secret) + " " + hex(salt) + "\n");
  std::filesystem::permissions(
      key, std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
}

std::string unlock_labels(const std::filesystem::path& folder, const std::filesystem::path& key) {
  start();
  std::istringstream parts(read_text(key));
  std::string secret_hex, salt_hex, box_hex;
  parts >> secret_hex >> salt_hex;
  const Bytes secret = from_hex(secret_hex), salt = from_hex(salt_hex);
  if (secret.size() != crypto_secretbox_KEYBYTES || salt.size() != kSalt) {
    throw InputError(fmt::format("{}: no key of `testbed seal`", key.string()));
  }

  std::istringstream(read_text(folder / "labels.sealed")) >> box_hex;
  const Bytes box = from_hex(box_hex);
  constexpr std::size_t kHead = crypto_secretbox_NONCEBYTES;
  const std::string file = (folder / "labels.sealed").string();
  if (box.size() < kHead + crypto_secretbox_MACBYTES)
    throw InputError(fmt::format("{}: no encrypted labels", file));
  std::string text(box.size() - kHead - crypto_secretbox_MACBYTES, '\0');
  if (crypto_secretbox_open_easy(reinterpret_cast<unsigned char*>(text.data()), box.data() + kHead,
                                 box.size() - kHead, box.data(), secret.data()) != 0) {
    throw InputError(fmt::format(
        "{}: the labels were altered or encrypted with another key than {}", file, key.string()));
  }

  std::string commitment;
  std::istringstream(read_text(folder / "commitment.txt")) >> commitment;
  if (commitment != commitment_of(salt, text)) {
    throw InputError(fmt::format("{}: the labels are not those committed to",
                                 (folder / "commitment.txt").string()));
  }
  return text;
}

std::uint64_t seed_of_hash(const std::string& hash) {
  start();
  if (hash.size() != 40 || from_hex(hash).empty()) {
    throw InputError(fmt::format(
        "--commit: '{}' given; allowed: a commit's full hash, 40 hexadecimal digits", hash));
  }
  std::array<unsigned char, crypto_generichash_BYTES> digest{};
  crypto_generichash(digest.data(), digest.size(),
                     reinterpret_cast<const unsigned char*>(hash.data()), hash.size(), nullptr, 0);
  std::uint64_t seed = 0;
  for (std::size_t i = 0; i < 8; ++i) seed = seed << 8 | digest[i];
  return seed >> 1;
}

}  // namespace jaculus::testbed
