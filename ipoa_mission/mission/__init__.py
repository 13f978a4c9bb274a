"""Read and write mission files, and convert missions to and from wire items."""
