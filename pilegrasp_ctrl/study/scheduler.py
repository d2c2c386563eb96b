"""The address of a dask scheduler and the certificates for it, checked before anything connects."""

from __future__ import annotations

import ssl
from dataclasses import dataclass
from typing import Any
from urllib.parse import urlsplit

from ..exceptions import ConfigurationError

SCHEMES = ("tcp", "tls")
"""Protocols of a scheduler that the library speaks; `tls` is encrypted, and both sides show a certificate."""
_EXAMPLE = "as in tcp://127.0.0.1:8786"


@dataclass(frozen=True, slots=True)
class Scheduler:
    """Where a dask scheduler listens, and how to talk to it.

    Without certificates, those of dask's own configuration are used (`distributed.comm.tls` in `~/.config/dask`).

    Attributes:
        address: tcp://HOST:PORT, tls://HOST:PORT, or HOST:PORT for tcp.
        tls_ca: Certificate of the authority that signed the scheduler's certificate, a PEM file.
        tls_cert: Certificate of this process, a PEM file.
        tls_key: Key of this process, a PEM file; None if it stands in `tls_cert`.

    Raises:
        ConfigurationError: The address has another form, or the certificates do not belong to it.
    """

    address: str
    tls_ca: str | None = None
    tls_cert: str | None = None
    tls_key: str | None = None

    def __post_init__(self) -> None:
        scheme, host, port = self._parts()
        if scheme != "tls" and (self.tls_ca or self.tls_cert or self.tls_key):
            raise ConfigurationError(
                f"--tls-ca, --tls-cert and --tls-key are for an address that begins with tls://, not {self._shown()}"
            )
        if (self.tls_ca is None) != (self.tls_cert is None) or (self.tls_key is not None and self.tls_cert is None):
            raise ConfigurationError(
                "give --tls-ca and --tls-cert together; --tls-key may stand in the file of --tls-cert"
            )
        bare_host = f"[{host}]" if ":" in host else host
        object.__setattr__(self, "address", f"{scheme}://{bare_host}:{port}")

    @property
    def host(self) -> str:
        """Name or number of the machine."""
        return self._parts()[1]

    @property
    def port(self) -> int:
        """Port of the scheduler."""
        return self._parts()[2]

    def connection_arguments(self) -> dict[str, Any]:
        """Return the arguments of dask's `Client` that belong to the certificates.

        Raises:
            ConfigurationError: A certificate is missing or cannot be read.
        """
        if self._parts()[0] != "tls":
            return {}
        from distributed import Security

        files = {"tls_ca_file": self.tls_ca, "tls_client_cert": self.tls_cert, "tls_client_key": self.tls_key}
        try:
            security = Security(
                require_encryption=True, **{name: file for name, file in files.items() if file is not None}
            )
            context = security.get_connection_args("client")["ssl_context"]
        except (OSError, ssl.SSLError, ValueError, TypeError) as error:
            used = ", ".join(repr(file)[:120] for file in files.values() if file) or "dask's configuration"
            raise ConfigurationError(f"the certificates in {used} cannot be used: {error}") from None
        if context is None:
            raise ConfigurationError(
                f"{self._shown()} needs certificates; give --tls-ca, --tls-cert and --tls-key, or name them under "
                "distributed.comm.tls in ~/.config/dask/distributed.yaml"
            )
        return {"security": security}

    def _parts(self) -> tuple[str, str, int]:
        """Return protocol, host and port."""
        text = self.address if isinstance(self.address, str) else ""
        scheme = text.partition("://")[0] if "://" in text else "tcp"
        try:
            split = urlsplit(text if "://" in text else f"tcp://{text}")
            host, port = split.hostname, split.port
        except ValueError:
            host = port = None
        bare = host is not None and not (split.path or split.query or split.fragment or "@" in split.netloc)
        if scheme not in SCHEMES or not bare or not port or not _is_host(str(host)):
            raise ConfigurationError(
                f"--scheduler {self._shown()} must be tcp://HOST:PORT or tls://HOST:PORT, {_EXAMPLE}"
            )
        return scheme, str(host), port

    def _shown(self) -> str:
        return f"{self.address!r:.80}"


def _is_host(text: str) -> bool:
    """Return whether a text can be the name or number of a machine."""
    return text.isprintable() and not any(letter.isspace() for letter in text)
