"""Takes away from an interpretation what the words deny, forbid or warn of. It never adds a permission."""
