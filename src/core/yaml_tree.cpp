#include "core/yaml_tree.h"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <map>
#include <sstream>
#include <unordered_set>

#include "jaculus/core/error.h"

namespace jaculus::yaml {
namespace {

// More nodes than any file of ours has, aliases written out; stops "billion laughs" before anything
// walks the tree.
constexpr double kMaxNodes = 1e6;

[[noreturn]] void fail(const std::string& name, int line, const std::string& what) {
  throw InputError({name, line}, what);
}

/// Length of the UTF-8 sequence that starts at `at`, 0 where it is malformed.
std::size_t utf8_length(const std::string& text, std::size_t at) {
  const auto byte = [&text](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(at);
  if (first < 0x80) return 1;
  const std::size_t length = first >= 0xF5   ? 0
                             : first >= 0xF0 ? 4
                             : first >= 0xE0 ? 3
                             : first >= 0xC2 ? 2
                                             : 0;
  if (length == 0 || at + length > text.size()) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(at + i) & 0xC0) != 0x80) return 0;
  }
  return length;
}

/// Binary data is refused before the parser sees it: the parser's messages on it help nobody.
void check_text(const std::string& text, const std::string& name) {
  int line = 1;
  for (std::size_t at = 0; at < text.size();) {
    const auto c = static_cast<unsigned char>(text[at]);
    const std::size_t length = utf8_length(text, at);
    const bool control = (c < 0x20 && c != '\t' && c != '\n' && c != '\r') || c == 0x7F;
    if (length == 0 || control)
      fail(name, line, fmt::format("byte 0x{:02x} found; allowed: YAML in UTF-8 text", c));
    if (c == '\n') ++line;
    at += length;
  }
}

class Builder : public YAML::EventHandler {
 public:
  explicit Builder(const std::string& name) : name_(name) {}

  std::shared_ptr<const Tree> root() const { return root_; }

  void OnDocumentStart(const YAML::Mark& /*mark*/) override {}
  void OnDocumentEnd() override {}

  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    leaf(mark, anchor, Tree::Kind::null, {}, false);
  }

  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    check_tag(mark, tag);
    leaf(mark, anchor, Tree::Kind::scalar, value, tag == "!");
  }

  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto found = anchors_.find(anchor);
    if (found == anchors_.end()) fail(name_, mark.line + 1, "alias to an unknown anchor");
    if (!found->second->complete) {
      fail(name_, mark.line + 1,
           "alias to a node that contains it (cyclic); an alias may only name a finished node");
    }
    attach(mark, found->second);
  }

  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value /*style*/) override {
    check_tag(mark, tag);
    open(mark, anchor, Tree::Kind::list);
  }
  void OnSequenceEnd() override { close(); }

  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value /*style*/) override {
    check_tag(mark, tag);
    open(mark, anchor, Tree::Kind::map);
  }
  void OnMapEnd() override { close(); }

 private:
  struct Open {
    std::shared_ptr<Tree> tree;
    YAML::anchor_t anchor;
    bool has_key = false;  ///< maps: a key was read, its value comes next
    std::string key;
    int key_line = 0;
    std::unordered_set<std::string> keys;
  };

  void check_tag(const YAML::Mark& mark, const std::string& tag) const {
    if (!tag.empty() && tag != "?" && tag != "!") {
      fail(name_, mark.line + 1,
           fmt::format("tag '{}' is not supported; allowed: values without tags", tag));
    }
  }

  static int line_of(const YAML::Mark& mark) { return mark.line + 1; }

  void leaf(const YAML::Mark& mark, YAML::anchor_t anchor, Tree::Kind kind,
            const std::string& value, bool quoted) {
    auto tree = std::make_shared<Tree>();
    tree->kind = kind;
    tree->line = line_of(mark);
    tree->quoted = quoted;
    tree->scalar = value;
    tree->complete = true;
    if (anchor != 0) anchors_[anchor] = tree;
    attach(mark, tree);
  }

  void open(const YAML::Mark& mark, YAML::anchor_t anchor, Tree::Kind kind) {
    if (!open_.empty() && open_.back().tree->kind == Tree::Kind::map && !open_.back().has_key)
      bad_key(mark);
    auto tree = std::make_shared<Tree>();
    tree->kind = kind;
    tree->line = line_of(mark);
    if (anchor != 0) anchors_[anchor] = tree;
    open_.push_back({tree, anchor, false, {}, 0, {}});
  }

  void close() {
    const std::shared_ptr<Tree> tree = open_.back().tree;
    open_.pop_back();
    tree->complete = true;
    attach({}, tree);
  }

  void attach(const YAML::Mark& mark, const std::shared_ptr<const Tree>& tree) {
    if (open_.empty()) {
      root_ = tree;
      return;
    }

    Open& top = open_.back();
    if (top.tree->kind == Tree::Kind::map && !top.has_key) {
      take_key(mark, *tree);
      return;
    }

    top.tree->expanded += tree->expanded;
    if (top.tree->expanded > kMaxNodes) {
      fail(name_, top.tree->line,
           "more than a million values with aliases written out; allowed: fewer");
    }

    if (top.tree->kind == Tree::Kind::map) {
      std::shared_ptr<const Tree> value = tree;
      if (tree->kind == Tree::Kind::null) value = null_at(top.key_line);
      top.tree->entries.push_back({top.key, top.key_line, value});
      top.has_key = false;
    } else {
      top.tree->items.push_back(tree);
    }
  }

  /// A key without a value: its line is the key's, not that of whatever comes next.
  static std::shared_ptr<const Tree> null_at(int line) {
    auto tree = std::make_shared<Tree>();
    tree->line = line;
    tree->complete = true;
    return tree;
  }

  void take_key(const YAML::Mark& mark, const Tree& tree) {
    if (tree.kind != Tree::Kind::scalar || tree.scalar.empty()) bad_key(mark);
    Open& top = open_.back();
    if (tree.scalar == "<<")
      fail(name_, tree.line, "key '<<': merge keys are not supported; write the values out");
    if (!top.keys.insert(tree.scalar).second) {
      fail(name_, tree.line,
           fmt::format("key '{}' given twice in one map; allowed: once", tree.scalar));
    }
    top.key = tree.scalar;
    top.key_line = tree.line;
    top.has_key = true;
  }

  [[noreturn]] void bad_key(const YAML::Mark& mark) const {
    fail(name_, mark.line + 1, "a key that is not plain text; allowed: words as keys");
  }

  std::string name_;
  std::shared_ptr<const Tree> root_;
  std::vector<Open> open_;
  std::map<YAML::anchor_t, std::shared_ptr<const Tree>> anchors_;
};

void emit(YAML::Emitter& out, const Tree& tree) {
  switch (tree.kind) {
    case Tree::Kind::null:
      out << YAML::Null;
      break;
    case Tree::Kind::scalar:
      if (tree.quoted) out << YAML::DoubleQuoted;
      out << tree.scalar;
      break;

    case Tree::Kind::list:
      out << YAML::Flow << YAML::BeginSeq;
      for (const auto& item : tree.items) emit(out, *item);
      out << YAML::EndSeq;
      break;

    case Tree::Kind::map:
      out << YAML::BeginMap;
      for (const auto& entry : tree.entries) {
        out << YAML::Key << entry.key << YAML::Value;
        emit(out, *entry.value);
      }
      out << YAML::EndMap;
      break;
  }
}

}  // namespace

std::shared_ptr<const Tree> parse_tree(const std::string& text, const std::string& name) {
  check_text(text, name);
  try {
    // The end marker makes the parser notice a quote that is never closed; without it the rest of
    // the file would be swallowed.
    std::istringstream stream(text + (text.ends_with('\n') ? "...\n" : "\n...\n"));
    YAML::Parser parser(stream);
    Builder builder(name);
    if (!parser.HandleNextDocument(builder) || !builder.root() ||
        builder.root()->kind == Tree::Kind::null) {
      fail(name, 1, "the file holds no value; allowed: a YAML document");
    }

    Builder second(name);
    if (parser.HandleNextDocument(second)) {
      fail(name, second.root() ? second.root()->line : 1,
           "a second document ('---'); allowed: one document a file");
    }

    return builder.root();
  } catch (const YAML::Exception& e) {
    const bool open_quote = e.msg.find("document indicator") != std::string::npos;
    fail(name, e.mark.line + 1,
         open_quote ? "not valid YAML: a quote is not closed; allowed: a YAML document"
                    : fmt::format("not valid YAML: {}; allowed: a YAML document", e.msg));
  }
}

std::string dump_tree(const Tree& tree) {
  YAML::Emitter out;
  emit(out, tree);
  return out.c_str();
}

}  // namespace jaculus::yaml
