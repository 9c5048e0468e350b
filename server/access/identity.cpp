#include "server/access/identity.hpp"

#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/x509v3.h>

#include <asio/ip/address.hpp>
#include <memory>
#include <stdexcept>

#include "core/base/json_document.hpp"
#include "protocol/crypto/private_file.hpp"
#include "server/access/listening.hpp"

namespace feltwire {
namespace {

template <auto free>
struct Freed {
  template <class T>
  void operator()(T* object) const {
    free(object);
  }
};
using CertificatePtr = std::unique_ptr<X509, Freed<X509_free>>;
using KeyPtr = std::unique_ptr<EVP_PKEY, Freed<EVP_PKEY_free>>;
using BioPtr = std::unique_ptr<BIO, Freed<BIO_free_all>>;
using ExtensionPtr = std::unique_ptr<X509_EXTENSION, Freed<X509_EXTENSION_free>>;

[[noreturn]] void fail(const char* what) {
  throw std::runtime_error(std::string("cannot make a certificate: ") + what + ": " +
                           last_tls_error());
}
void need(bool good, const char* what) {
  if (!good) fail(what);
}

BioPtr reader(std::string_view text) {
  return BioPtr(BIO_new_mem_buf(text.data(), static_cast<int>(text.size())));
}

std::string_view written(const BioPtr& bio) {
  char* bytes = nullptr;
  const long size = BIO_get_mem_data(bio.get(), &bytes);
  return {bytes, static_cast<std::size_t>(size)};
}

CertificatePtr first_certificate(const Identity& identity) {
  return CertificatePtr(
      PEM_read_bio_X509(reader(identity.certificate).get(), nullptr, nullptr, nullptr));
}

/// Returns an empty passphrase, so that OpenSSL does not ask for one at the terminal.
int no_passphrase(char*, int, int, void*) { return 0; }

std::string alternative_names(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) {
    std::error_code no_address;
    asio::ip::make_address(name, no_address);
    list += (list.empty() ? "" : ",") + std::string(no_address ? "DNS:" : "IP:") + name;
  }
  return list;
}

void add_extension(X509& certificate, int kind, const std::string& value) {
  X509V3_CTX context;
  X509V3_set_ctx_nodb(&context);
  X509V3_set_ctx(&context, &certificate, &certificate, nullptr, nullptr, 0);
  const ExtensionPtr extension(X509V3_EXT_conf_nid(nullptr, &context, kind, value.c_str()));
  need(extension && X509_add_ext(&certificate, extension.get(), -1) == 1, value.c_str());
}

}  // namespace

Identity make_identity(const std::vector<std::string>& names) {
  constexpr long kDay = 24L * 3600, kYears = 10L * 365 * kDay;  // [s] one day, ten years
  constexpr int kSerialBits = 127;
  const KeyPtr key(EVP_EC_gen("P-256"));
  const CertificatePtr certificate(X509_new());
  need(key && certificate, "no key");
  X509& c = *certificate;
  const std::unique_ptr<BIGNUM, Freed<BN_free>> serial(BN_new());
  need(serial && BN_rand(serial.get(), kSerialBits, BN_RAND_TOP_ONE, BN_RAND_BOTTOM_ANY) == 1 &&
           BN_to_ASN1_INTEGER(serial.get(), X509_get_serialNumber(&c)) != nullptr,
       "no serial number");
  X509_NAME* name = X509_get_subject_name(&c);
  const auto* title = reinterpret_cast<const unsigned char*>("feltwire-server");
  // The certificate is valid from yesterday on, for clients whose clock is slow.
  need(X509_set_version(&c, X509_VERSION_3) == 1 &&
           X509_gmtime_adj(X509_getm_notBefore(&c), -kDay) != nullptr &&
           X509_gmtime_adj(X509_getm_notAfter(&c), kYears) != nullptr &&
           X509_NAME_add_entry_by_txt(name, "CN", MBSTRING_ASC, title, -1, -1, 0) == 1 &&
           X509_set_issuer_name(&c, name) == 1 && X509_set_pubkey(&c, key.get()) == 1,
       "its fields");
  add_extension(c, NID_basic_constraints, "critical,CA:FALSE");
  add_extension(c, NID_key_usage, "critical,digitalSignature");
  add_extension(c, NID_ext_key_usage, "serverAuth,clientAuth");  // for both sides of mutual TLS
  add_extension(c, NID_subject_alt_name, alternative_names(names));
  need(X509_sign(&c, key.get(), EVP_sha256()) > 0, "its signature");

  const BioPtr certificate_text(BIO_new(BIO_s_mem())), key_text(BIO_new(BIO_s_secmem()));
  need(PEM_write_bio_X509(certificate_text.get(), &c) == 1 &&
           PEM_write_bio_PrivateKey(key_text.get(), key.get(), nullptr, nullptr, 0, nullptr,
                                    nullptr) == 1,
       "its text");
  return {std::string(written(certificate_text)), Secret(written(key_text))};
}

Identity load_identity(const std::filesystem::path& certificate, const std::filesystem::path& key) {
  if (const auto open = exposure(key)) throw FileError(*open);
  std::string key_text = read_text(key);
  Identity identity{read_text(certificate), Secret(key_text)};
  wipe(key_text);
  const CertificatePtr first = first_certificate(identity);
  if (!first)
    throw FileError(certificate.string() + ": holds no certificate (" + last_tls_error() +
                    "); give one in PEM");
  const KeyPtr private_key(
      PEM_read_bio_PrivateKey(reader(identity.key.text()).get(), nullptr, no_passphrase, nullptr));
  if (!private_key)
    throw FileError(key.string() + ": holds no private key (" + last_tls_error() +
                    "); give one in PEM, without a passphrase");
  if (X509_check_private_key(first.get(), private_key.get()) != 1)
    throw FileError(key.string() + ": is not the key of the certificate in " +
                    certificate.string() + "; give the two that belong together");
  try {
    server_tls(identity);
  } catch (const std::exception& error) {
    throw FileError(certificate.string() + ": TLS refuses it (" + error.what() +
                    "); check that the file is whole and its keys are long enough");
  }
  return identity;
}

Fingerprint fingerprint(const Identity& identity) {
  const CertificatePtr first = first_certificate(identity);
  if (!first) throw std::runtime_error("no certificate: " + last_tls_error());
  return fingerprint(*first);
}

}  // namespace feltwire
