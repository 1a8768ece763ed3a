"""Exported files: tables, pictures, archives."""
