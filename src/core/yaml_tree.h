#pragma once
// The document behind yaml::Node: an immutable tree, built from the events of yaml-cpp's parser so
// that duplicate keys, cyclic aliases and tags are seen (its own tree hides them), and so that
// nodes may be read from several threads.

#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace jaculus::yaml {

struct Tree {
  enum class Kind { null, scalar, list, map };
  struct Entry {
    std::string key;
    int line;  ///< of the key
    std::shared_ptr<const Tree> value;
  };

  Kind kind = Kind::null;
  int line = 0;           ///< 1-based
  bool quoted = false;    ///< scalars: written in quotes or as a block
  bool complete = false;  ///< false while its end has not been read; an alias to it is then cyclic
  double expanded = 1.0;  ///< nodes in it with every alias written out
  std::string scalar;
  std::vector<std::shared_ptr<const Tree>> items;
  std::vector<Entry> entries;
};

/// Parses one document. `name` stands for the file in messages.
std::shared_ptr<const Tree> parse_tree(const std::string& text, const std::string& name);

/// YAML text of a tree, in flow style inside lists.
std::string dump_tree(const Tree& tree);

}  // namespace jaculus::yaml
