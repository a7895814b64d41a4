"""What the program adds to its environment and to the user's desktop, and takes away again."""
