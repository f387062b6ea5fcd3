"""Normal contact laws, one a file."""
