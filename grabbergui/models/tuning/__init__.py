"""One-push exposure and white balance."""
