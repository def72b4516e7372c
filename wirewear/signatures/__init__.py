"""What an effect does to a test: runs without and with it side by side, and a picture of what differs."""

from wirewear.signatures.signature import Signature, signature_of, signature_study

__all__ = ["Signature", "signature_of", "signature_study"]
